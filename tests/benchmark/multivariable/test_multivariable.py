"""The multivariable benchmark: models, measures, built-in designs and demands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.benchmark.models import NOMINAL, RULES
from flexros.benchmark.multivariable.coupled import cost_with_demands, coupled_pid, settings_of_coupled, tuned_on
from flexros.benchmark.multivariable.evaluate import (
    SETTLED,
    MotionBenchmark,
    load_motion_controller,
    motion_controller_names,
)
from flexros.benchmark.multivariable.measures import lost_run, measures_of_motion, worst_motion
from flexros.benchmark.multivariable.problem import MODELS, PROBLEMS, problem_named
from flexros.benchmark.multivariable.tuning import settings_of
from flexros.control.base import control_law
from flexros.control.design.fixed_structure import pid_system
from flexros.errors import InputError

E12 = problem_named("e12")
FIRST = np.concatenate([*[np.eye(2).ravel()] * 3, np.zeros(9)])
"""First point of the coupled search."""


@pytest.fixture(scope="module")
def bench() -> MotionBenchmark:
    return MotionBenchmark(E12, threads=1)


@pytest.mark.parametrize("name", list(PROBLEMS))
def test_models_are_within_the_deviations_of_their_set(name: str) -> None:
    problem = PROBLEMS[name]
    for key, rules in RULES.items():
        values = problem.values(key)
        nominal = {parameter: problem.robot.parameters[parameter].value for parameter in values}
        ratios = {parameter: found / nominal[parameter] - 1.0 for parameter, found in values.items()}
        assert all(len(found) == (1 if key == NOMINAL else MODELS) for found in ratios.values())
        stiffness = np.abs([found for parameter, found in ratios.items() if parameter.endswith(".stiffness")])
        assert np.max(stiffness) <= rules.stiffness
        assert np.max(stiffness) > 0.7 * rules.stiffness or key == NOMINAL


def test_windows_cover_the_run_without_gaps() -> None:
    for problem in PROBLEMS.values():
        for before, after in zip(problem.windows, problem.windows[1:], strict=False):
            assert before.end == after.start


def test_measures_of_a_known_course() -> None:
    step, n = 1e-2, 1260
    time = step * np.arange(n)
    error = np.zeros((n, 3))
    error[:, 0] = np.where(time >= 1.5 - 1e-9, 2.0 * np.exp(-(time - 1.5) / 0.1), 0.0)
    command = np.zeros((n, 2))
    command[120, 1], command[700, 0] = 30.0, -1500.0
    found = measures_of_motion(E12, NOMINAL, error, command, step)
    assert found.deflection[0] == pytest.approx(2.0)
    assert found.settling[0] == pytest.approx(0.1 * np.log(2.0 / 0.2), abs=2 * step)
    assert found.noise_torque == pytest.approx(1.0, rel=0.1)
    assert found.largest_torque == pytest.approx(50.0)
    worst = worst_motion([found, replace(found, noise_torque=3.0)])
    assert worst.noise_torque == 3.0
    assert lost_run(E12).cost > 100 * found.cost


def test_every_design_loads_and_a_wrong_name_is_refused() -> None:
    for problem in PROBLEMS.values():
        for name in motion_controller_names(problem):
            law = load_motion_controller(problem, name).nominal
            law.check(law.context(problem.robot, 5e-4))
    with pytest.raises(InputError, match="pid"):
        load_motion_controller(E12, "pidd")
    with pytest.raises(InputError, match="six_axis"):
        problem_named("elbow")


@pytest.mark.slow
def test_the_nominal_model_follows_its_path_and_errors_of_the_model_show(bench: MotionBenchmark) -> None:
    law = load_motion_controller(E12, "pid").nominal
    nominal, perturbed = (bench.measures_of_set(name, law, noise=False) for name in (NOMINAL, "M1"))
    motion = [window.name for window in E12.windows].index("motion")
    assert nominal.deflection[motion] < 1.0 < 5.0 < perturbed.deflection[motion]
    assert nominal.cost < perturbed.cost
    assert np.max(np.abs(bench.path - bench.experiment(law).reference.tool_pose[:, :3])) < 1e-5


def test_a_changed_run_keeps_the_reference_of_the_problem(bench: MotionBenchmark) -> None:
    one, other = (bench.experiment(load_motion_controller(E12, name).nominal) for name in ("pid", "coupled_pid"))
    quiet = replace(one, scenario=one.scenario.model_copy(update={"disturbances": ()}))
    assert quiet.reference is one.reference is other.reference


def test_a_loop_that_is_too_fast_misses_the_demand_on_stability(bench: MotionBenchmark) -> None:
    good = bench.stability(load_motion_controller(E12, "pid").nominal)
    fast = bench.stability(control_law(settings_of(E12, "pid", np.array([60.0, 1.0, 0.1, 1e-3]))))
    assert all(demand.passed for demand in good)
    assert not any(demand.passed for demand in fast)


def test_the_coupled_pid_without_coupling_is_the_law_pid() -> None:
    gains = np.diag([3.0, 7.0])
    both = coupled_pid(gains, 2 * gains, 0.1 * gains, 4e-3, 5e-4)
    frequency = np.array([0.3, 5.0, 200.0])
    for motor in range(2):
        alone = pid_system(gains[motor, motor], 2 * gains[motor, motor], 0.1 * gains[motor, motor], 4e-3, 5e-4)
        found = both.response(frequency, 5e-4)
        assert found[:, motor, motor] == pytest.approx(alone.response(frequency, 5e-4)[:, 0, 0])
        assert not np.any(found[:, motor, 1 - motor])


@pytest.mark.slow
def test_the_coupled_search_lowers_the_cost_of_its_start(bench: MotionBenchmark) -> None:
    pytest.importorskip("cma")
    first = cost_with_demands(bench, settings_of_coupled(bench, FIRST), (NOMINAL,))
    found = cost_with_demands(bench, tuned_on(bench, (NOMINAL,), 8), (NOMINAL,))
    assert found < first - 1.0


def test_the_coupled_design_settles_in_time_on_the_nominal_model(bench: MotionBenchmark) -> None:
    design = load_motion_controller(E12, "coupled_pid")
    found = bench.measures_of_set(NOMINAL, design.nominal)
    assert np.max(found.settling) < SETTLED
    assert found.cost < 0.95 * bench.measures_of_set(NOMINAL, load_motion_controller(E12, "pid").nominal).cost
    assert all(demand.passed for demand in bench.stability(design.perturbed))
