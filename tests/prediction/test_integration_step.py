"""Step of predictors: long for slow robots, short for fast ones and for effects with fast states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction import compiled_plant
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.prediction.integration_step import IntegrationSteps, integration_steps, substeps
from flexros.record.read import read_record
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


@pytest.mark.parametrize(
    ("name", "sample_time", "steps"),
    [("six_axis", 5e-4, 1), ("six_axis", 4e-3, 5), ("six_axis", 0.01, 11), ("emps", 0.01, 1), ("emps", 0.03, 3)],
)
def test_the_fastest_motion_of_a_robot_decides(name: str, sample_time: float, steps: int) -> None:
    assert substeps(load_robot(name), sample_time) == steps


@pytest.mark.parametrize(("name", "sample_time", "steps"), [
    ("six_axis", 0.004, 2),
    ("six_axis", 5e-4, 1),
    ("elbow", 0.004, 1),
])  # fmt: skip
def test_where_only_changes_count_steps_are_up_to_a_radian_long(name: str, sample_time: float, steps: int) -> None:
    assert substeps(load_robot(name), sample_time, rough=True) == steps


def test_friction_over_speed_and_servos_get_short_steps() -> None:
    assert substeps(load_robot("emps"), 0.01, curved=True) == 4
    assert substeps(_braked(0.0, ", servo: {stiffness: 0.01, damping: 0.001}").commanded_by("position"), 0.01) == 4


def test_a_motion_that_dies_out_needs_steps_of_its_time_constant_alone() -> None:
    swinging = _braked(0.0, ", servo: {stiffness: 25, damping: 0}").commanded_by("position")  # as fast, 500 rad/s
    assert substeps(_braked(0.05), 0.004) == 2
    assert substeps(swinging, 0.004) == 5


def test_effects_with_fast_states_get_at_most_five_steps_in_a_sample() -> None:
    assert substeps(load_robot("emps"), 2e-3, fast=True) == 4
    assert substeps(load_robot("emps"), 0.02, fast=True) == 5


def _braked(friction: float = 1.0, servo: str = "") -> Robot:
    """A joint that friction of 1 Nm s/rad stops with a time constant of 0.1 ms."""
    brake = f"{{spring: rigid, motor: {{inertia: 1.0e-4, viscous_friction: {friction}{servo}}}}}"
    data = {"name": "brake", "bodies": [{"directions": {"ry": yaml.safe_load(brake)}}], "controlled": "j"}
    return robot_from_data({**data, "outputs": {"j": {"coordinates": ["body_1.ry"]}}}, "brake.yaml")


def test_much_damping_on_little_inertia_needs_steps_that_do_not_grow() -> None:
    assert substeps(_braked(), 0.004) == substeps(_braked(), 0.004, fast=True) == 16
    assert substeps(_braked(0.0), 0.004, (1.0,)) == 16


def test_steps_are_implicit_where_motions_die_out_within_a_sample() -> None:
    assert integration_steps(_braked(), 0.004, may_be_implicit=True).implicit
    assert not integration_steps(_braked(), 0.004, may_be_implicit=False).implicit


@pytest.mark.parametrize(("sample_time", "options", "number"), [
    (0.004, {}, 3),
    (0.02, {}, 3),
    (0.1, {}, 8),  # no longer than 12.5 ms
    (0.02, {"fast": True}, 5),
    (0.004, {"rough": True}, 2),
])  # fmt: skip
def test_torques_that_are_held_take_few_implicit_steps(
    sample_time: float, options: dict[str, bool], number: int
) -> None:
    steps = integration_steps(_braked(), sample_time, may_be_implicit=True, **options)
    assert steps == IntegrationSteps(number, implicit=True)


@pytest.mark.parametrize(("sample_time", "rough", "number"), [(0.004, False, 5), (0.02, False, 20), (0.004, True, 2)])
def test_servos_take_implicit_steps_of_a_millisecond(sample_time: float, rough: bool, number: int) -> None:
    held = _braked(0.0, ", servo: {stiffness: 100, damping: 2.0}").commanded_by("position")
    steps = integration_steps(held, sample_time, may_be_implicit=True, rough=rough)
    assert steps == IntegrationSteps(number, implicit=True)


def test_friction_beside_that_of_the_robot_counts() -> None:
    assert not integration_steps(_braked(0.0), 0.004, may_be_implicit=True).implicit
    assert integration_steps(_braked(0.0), 0.004, (1.0,), may_be_implicit=True).implicit


def test_a_servo_that_swings_needs_runge_kutta_steps() -> None:
    """Implicit steps as long as these would damp its vibration at 160 Hz."""
    swinging, braked = (
        _braked(0.0, f", servo: {{stiffness: 100, damping: {damping}}}").commanded_by("position")
        for damping in (0.02, 2.0)
    )
    assert not integration_steps(swinging, 0.004, may_be_implicit=True).implicit
    assert integration_steps(braked, 0.004, may_be_implicit=True).implicit


@pytest.mark.slow
def test_the_steps_of_a_slowly_sampled_arm_change_the_errors_by_less_than_chance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot, nothing = load_robot("six_axis"), np.zeros((0, 1))
    keys = {"robot": robot.name, "seed": 1, "diagnosis.length": 10, "sample_time": 4e-3, "diagnosis.parts": ["moves"]}
    log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(keys)))
    model = RobotWithEffects(robot, ())
    data = fit_data(replace(read_record(log, robot, name="log"), tool=None), model, DiagnosisSettings())

    def squares() -> float:
        return float(np.sum(data.residuals(Predictor(model, (), Tolerance(), 4e-3), nothing) ** 2))

    usual = squares()
    monkeypatch.setattr(compiled_plant, "integration_steps", lambda *_, **__: IntegrationSteps(16, implicit=False))
    assert usual == pytest.approx(squares(), abs=0.1 * np.sqrt(2 * data.n_values))
