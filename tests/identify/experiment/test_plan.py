"""The plan of an identification experiment."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.experiment.plan import ExperimentPlan
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.logs.write_log import write_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification_plan import plan_of_log, plan_of_scenario
from flexros.scenario.scenario import Scenario, load_scenario

Plans = Callable[..., ExperimentPlan]
Scenarios = Callable[..., Scenario]


def same(one: ExperimentPlan, two: ExperimentPlan) -> bool:
    return (
        (one.segments, one.visits, one.n_samples) == (two.segments, two.visits, two.n_samples)
        and np.array_equal(one.excited_lines, two.excited_lines)
        and np.array_equal(one.signals(1, 0).speed, two.signals(1, 0).speed)
    )


def test_every_position_has_its_blocks_of_one_experiment_per_motor(plan_of: Plans) -> None:
    plan = plan_of(positions=[[0, 0.3], [0.1, 0.4], [0.2, 0.5]], blocks=[2, 0, 1])
    places = [(s.position, s.block, s.experiment) for s in plan.segments]
    assert places == [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (2, 0, 0), (2, 0, 1)]
    assert all((s.n_periods, s.period) == (2, 1000) for s in plan.segments)
    assert [visit.position for visit in plan.visits] == [0, 2]


def test_blocks_at_constant_speed_run_in_pairs_of_one_direction_each(plan_of: Plans) -> None:
    plan = plan_of(positions=[[0, 0.3]], blocks=3, slow_motion={"kind": "constant_speed", "speed": 0.2})
    places = [(s.block, s.experiment) for s in plan.segments]
    assert places == [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1)]
    directions = {block: {number % 2 for number, (b, _) in enumerate(places) if b == block} for block in (0, 1)}
    assert directions == {0: {0}, 1: {1}}


def test_transients_and_fades_lie_before_the_recorded_periods(plan_of: Plans) -> None:
    plan = plan_of()
    first, second = plan.segments[:2]
    assert first.first == plan.visits[0].begin_first + 600 + 1000
    assert second.first == first.stop + 600 + 600 + 1000
    assert plan.segments[-1].stop + 600 == plan.visits[-1].end == plan.n_samples - 1


def test_lines_are_multiples_of_one_over_the_period(plan_of: Plans) -> None:
    plan = plan_of()
    assert plan.periodic
    assert plan.period_samples == 1000
    np.testing.assert_allclose(plan.frequency, plan.excited_lines / 0.5)
    assert set(plan.excited_lines) | set(plan.odd_detection_lines) == set(range(3, 21, 2))
    assert set(plan.even_detection_lines) == set(range(4, 19, 2))


def test_line_of_a_slow_sine_is_no_detection_line(plan_of: Plans) -> None:
    plan = plan_of(slow_motion={"kind": "sine", "speed": 0.1, "cycles": 4})
    assert 4 not in plan.even_detection_lines
    assert 6 in plan.even_detection_lines


def test_records_of_a_burst_are_not_periodic(plan_of: Plans) -> None:
    plan = plan_of(excitation={"kind": "burst", "duration": 1.0, "rest_before": 0.1, "rest_after": 0.4}, periods=1)
    assert not plan.periodic
    assert all((s.n_periods, s.period) == (1, 3000) for s in plan.segments)
    assert plan.segments[0].first == plan.visits[0].begin_first


def test_default_of_fifteen_positions_takes_less_than_27_minutes() -> None:
    random = np.random.default_rng(2)
    settings = load_scenario("identify_six_axis").settings()
    settings["identification"] = {"positions": random.uniform(-0.6, 0.6, (15, 6)).tolist()}
    plan = plan_of_scenario(Scenario.model_validate(settings))
    assert plan.duration < 27 * 60
    assert len(plan.segments) == 15 * 2 * 6


def test_seed_of_the_scenario_makes_phases_unless_the_identification_has_its_own(scenario_of: Scenarios) -> None:
    one, two = (plan_of_scenario(scenario_of().with_values({"seed": seed})) for seed in (1, 2))
    assert not same(one, two)
    mine = scenario_of(seed=7)
    assert same(*(plan_of_scenario(mine.with_values({"seed": seed})) for seed in (1, 2)))


@pytest.mark.slow
def test_plan_is_found_again_in_the_log(scenario_of: Scenarios, tmp_path: Path) -> None:
    experiment = Experiment.prepare(scenario_of(slow_motion={"kind": "constant_speed", "speed": 0.2}))
    log = closed_loop(experiment)
    assert experiment.plan is not None
    assert same(plan_of_log(log), experiment.plan)
    write_log(log, tmp_path / "log")
    again = read_log(tmp_path / "log")
    assert same(plan_of_log(again), experiment.plan)
    assert len(again.joint_states.stamp) == experiment.plan.n_samples


@pytest.mark.slow
@pytest.mark.parametrize(
    ("provenance", "message"),
    [
        ({}, r"the provenance of the log holds no scenario, .* give the scenario of the experiment"),
        (
            {"scenario": {"identification": None}},
            r"log is of a scenario without identification, .* give the scenario of the experiment",
        ),
        ({"scenario": {"identification": {}}}, r"provenance of the log, key scenario: key 'robot' is missing"),
    ],
)
def test_log_without_plan_says_what_to_give(
    provenance: dict[str, object], message: str, scenario_of: Scenarios
) -> None:
    log = closed_loop(Experiment.prepare(load_scenario("two_mass_step")))
    with pytest.raises(InputError, match=message):
        plan_of_log(replace(log, provenance=provenance))
    assert isinstance(log, Log)


def test_scenario_without_identification_has_no_plan() -> None:
    with pytest.raises(InputError, match="scenario circle_dae has no key identification"):
        plan_of_scenario(load_scenario("circle_dae"))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"positions": [[0.0, 0.3], [0.1]]},
            r"identification\.positions\[1\] has 1 gear angles, allowed is one for each",
        ),
        ({"move": {"speed": [1, 1, 1]}}, r"identification\.move\.speed has 3 values, allowed is one, or one for each"),
        ({"excitation": {"kind": "multisine", "amplitude": [1, 1, 1]}}, r"identification\.excitation\.amplitude has 3"),
        ({"slow_motion": {"kind": "sine", "speed": [1, 1, 1]}}, r"identification\.slow_motion\.speed has 3 values"),
        ({"limits": {"speed": [1, 1, 1]}}, r"identification\.limits\.speed has 3 values"),
        (
            {"limits": {"position": [[-1, 1]]}},
            r"identification\.limits\.position has 1 ranges, .* each of the 2 motors",
        ),
        (
            {"slow_motion": {"kind": "sine", "speed": 0.1, "cycles": 3}, "seed": 4},
            r"slow_motion\.cycles is 3, a line that the excitation uses, allowed is a line it leaves out",
        ),
        ({"blocks": 900}, r"the experiment lasts .* s, allowed are at most 7200 s; take fewer positions, blocks"),
        (
            {"excitation": {"kind": "multisine", "period": 0.5001}},
            r"identification: excitation\.period is 0\.5001 s, allowed is a whole number of samples",
        ),
    ],
)
def test_impossible_plans_name_the_key(plan_of: Plans, settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=r"scenario mine: .*" + message):
        plan_of(**settings)


def test_provenance_is_plain_data(scenario_of: Scenarios) -> None:
    provenance = Experiment.prepare(scenario_of()).provenance()
    assert json.loads(json.dumps(provenance, allow_nan=False))["scenario"]["identification"]["blocks"] == 1
