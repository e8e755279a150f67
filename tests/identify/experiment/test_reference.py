"""The reference of an identification experiment."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.feedforward.motion import Reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.identify.experiment.plan import ExperimentPlan
from flexros.identify.experiment.reference import identification_reference, moves_of
from flexros.robot import load_robot
from flexros.scenario.scenario import Scenario

Scenarios = Callable[..., Scenario]
Plans = Callable[..., ExperimentPlan]
SLOW: list[dict[str, object]] = [
    {"kind": "none"},
    {"kind": "constant_speed", "speed": [0.3, 0.2]},
    {"kind": "sine", "speed": 0.1},
]
BURST = {"kind": "burst", "duration": 0.8, "rest_before": 0.1, "rest_after": 0.3, "lowest": 3.0, "highest": 40.0}


def reference_of(plan: ExperimentPlan, method: str = "flexible_joint") -> Reference:
    settings = FeedforwardSpecification.model_validate({"method": method})
    return identification_reference(plan, load_robot("e12"), settings)


@pytest.mark.slow
@pytest.mark.parametrize("slow", SLOW, ids=lambda slow: str(slow["kind"]))
def test_recorded_speed_is_periodic_with_energy_on_the_excited_lines_only(
    plan_of: Plans, slow: dict[str, object]
) -> None:
    plan = plan_of(slow_motion=slow)
    speed = reference_of(plan).motor_velocity
    allowed = {*plan.excited_lines, *([1] if slow["kind"] == "sine" else []), 0}
    empty = [k for k in range(501) if k not in allowed]
    for s in plan.segments:
        U = np.fft.rfft(speed[s.first : s.stop].reshape(s.n_periods, s.period, -1), axis=1)
        assert np.max(np.abs(U[:, empty])) < 1e-11 * np.max(np.abs(U))
        assert np.min(np.abs(U[:, plan.excited_lines])) > 1e-3 * np.max(np.abs(U))
        np.testing.assert_allclose(U[0], U[1], atol=1e-11 * np.max(np.abs(U)))


@pytest.mark.slow
@pytest.mark.parametrize("excitation", [None, BURST], ids=["multisine", "burst"])
@pytest.mark.parametrize("slow", SLOW, ids=lambda slow: str(slow["kind"]))
def test_position_is_the_integral_of_the_speed_throughout(
    plan_of: Plans, slow: dict[str, object], excitation: dict[str, object] | None
) -> None:
    plan = plan_of(slow_motion=slow, **({} if excitation is None else {"excitation": excitation}))
    reference = reference_of(plan)
    x, v = reference.motor_position, reference.motor_velocity
    moved = plan.sample_time / 3.0 * (v[:-2] + 4.0 * v[1:-1] + v[2:])  # Simpson's rule
    np.testing.assert_allclose(x[2:] - x[:-2], moved, atol=2e-8)


@pytest.mark.slow
@pytest.mark.parametrize("slow", SLOW, ids=lambda slow: str(slow["kind"]))
def test_robot_stays_near_its_positions_and_ends_in_the_last_one_at_rest(
    plan_of: Plans, slow: dict[str, object]
) -> None:
    plan = plan_of(slow_motion=slow)
    reference = reference_of(plan)
    np.testing.assert_allclose(reference.motor_position[-1], [0.1, 0.4], atol=1e-12)
    assert not np.any(reference.motor_velocity[-1])
    for visit in plan.visits:
        stay = reference.motor_position[visit.begin_first : visit.begin_first + 2 * visit.experiment]
        np.testing.assert_allclose(np.mean(stay, axis=0), plan.positions[visit.position], atol=2e-3)


def test_constant_speed_changes_its_sign_and_is_the_mean_of_the_recorded_speed(plan_of: Plans) -> None:
    plan = plan_of(slow_motion=SLOW[1], blocks=2)
    speed = reference_of(plan).motor_velocity
    means = np.array([np.mean(speed[s.first : s.stop], axis=0) for s in plan.segments[:4]])
    np.testing.assert_allclose(means, np.outer([1, -1, 1, -1], [0.3, 0.2]), rtol=1e-9)


def test_constant_speed_that_is_fast_enough_never_stops_while_recording(plan_of: Plans) -> None:
    plan = plan_of(slow_motion=SLOW[1])
    speed = reference_of(plan).motor_velocity
    for s in plan.segments:
        within = speed[s.first : s.stop]
        assert np.all(within > 0.0) or np.all(within < 0.0)


def test_first_experiment_begins_where_the_approach_ended(plan_of: Plans) -> None:
    plan = plan_of(slow_motion=SLOW[1])
    reference = reference_of(plan)
    for visit in plan.visits:
        for k in range(visit.n_experiments + 1):
            at = visit.begin_first + k * visit.experiment
            assert np.max(np.abs(reference.motor_velocity[at])) < 1e-12
            away = reference.motor_position[at] - plan.positions[visit.position]
            np.testing.assert_allclose(away, (-1) ** (k + 1) * 0.5 * 1.8 * np.array([0.3, 0.2]), atol=1e-9)


def test_approach_of_a_constant_speed_accelerates_no_more_than_its_fade(plan_of: Plans) -> None:
    plan = plan_of(slow_motion=SLOW[1], move={"speed": 5.0, "acceleration": 50.0})
    reference = reference_of(plan)
    visit = plan.visits[0]
    approach = np.diff(reference.motor_velocity[visit.lead : visit.begin_first], axis=0) / plan.sample_time
    assert np.max(np.abs(approach)) <= 1.01 * 2.47 * 0.3 / 0.3
    assert np.max(np.abs(approach)) > 1.0


def test_feedforward_holds_the_torque_of_gravity_during_a_stay() -> None:
    robot = load_robot("elbow")
    scenario = Scenario.model_validate(
        {
            "name": "mine",
            "robot": "elbow",
            "feedforward": {"method": "flexible_joint"},
            "controller": {"kind": "pid", "kp": 1e4},
            "identification": {
                "positions": [[0.3, 0.5], [0.8, 0.2]],
                "blocks": 1,
                "excitation": {"kind": "multisine", "period": 0.5, "lowest": 3.0, "highest": 20.0},
            },
        }
    )
    plan = ExperimentPlan.build(scenario.identification, robot, robot.sample_time, 1)  # type: ignore[arg-type]
    reference = identification_reference(plan, robot, scenario.feedforward)
    for visit in plan.visits:
        torque = reference.torque[visit.lead : visit.end - 50]
        state = robot.equilibrium(robot.home, motor_position=reference.motor_position[visit.lead])
        np.testing.assert_allclose(torque, np.broadcast_to(robot.holding_torque(state), torque.shape), rtol=1e-6)
        assert np.max(np.abs(torque)) > 10.0


@pytest.mark.slow
@pytest.mark.parametrize("method", ["none", "rigid", "flexible_joint", "dae"])
def test_held_torque_joins_moves_without_a_step(plan_of: Plans, method: str) -> None:
    plan = plan_of()
    torque = reference_of(plan, method).torque
    assert np.max(np.abs(np.diff(torque, axis=0))) <= 0.02 * np.max(np.abs(torque))


def test_moves_take_whole_samples_and_lead_from_position_to_position(plan_of: Plans) -> None:
    plan = plan_of(positions=[[0, 0.3], [0.1, 0.4], [0.3, 0.1]])
    moves = moves_of(plan)
    np.testing.assert_allclose(np.mod(moves.begins / plan.sample_time + 0.5, 1.0), 0.5, atol=1e-6)
    ends = [move.path.point_at(move.law.end) for move in moves.moves]
    np.testing.assert_allclose(ends, plan.positions)


@pytest.mark.slow
def test_experiment_gives_this_reference(scenario_of: Scenarios) -> None:
    from flexros.scenario.experiment import Experiment

    experiment = Experiment.prepare(scenario_of())
    assert experiment.plan is not None
    assert experiment.n_samples == experiment.plan.n_samples == len(experiment.reference)
    assert np.array_equal(experiment.reference.motor_velocity, reference_of(experiment.plan).motor_velocity)
    unaided = Experiment.prepare(scenario_of().with_values({"feedforward_torque": False}))
    assert not np.any(unaided.reference.torque)


@pytest.mark.slow
def test_torque_held_during_a_stay_has_no_part_of_the_next_move(plan_of: Plans) -> None:
    plan, robot = plan_of(), load_robot("e12")
    effects = ("delay@motor_1:time=0.02", "delay@motor_2:time=0.02", "backlash@motor_1:gap=0.001")
    laws = place_effects(robot, [parse_effect(text, "test") for text in effects]).laws
    reference = identification_reference(plan, robot, FeedforwardSpecification(method="flexible_joint"), laws=laws)
    largest = np.abs(reference.torque).max()
    stays = [slice(visit.lead + 2, visit.end - 2 * round(0.1 / plan.sample_time)) for visit in plan.visits]
    held = [np.abs(reference.torque[stay]).max() for stay in stays]
    assert len(held) > 1
    assert max(held) < 1e-9 * largest
