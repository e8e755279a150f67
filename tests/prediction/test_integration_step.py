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
from flexros.prediction.integration_step import substeps
from flexros.record.read import read_record
from flexros.robot import load_robot, robot_from_data
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


@pytest.mark.parametrize(
    ("name", "sample_time", "steps"),
    [("six_axis", 5e-4, 1), ("six_axis", 4e-3, 5), ("six_axis", 0.01, 11), ("emps", 0.01, 4)],
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


def test_effects_with_fast_states_get_at_most_five_steps_in_a_sample() -> None:
    assert substeps(load_robot("emps"), 2e-3, fast=True) == 4
    assert substeps(load_robot("emps"), 0.02, fast=True) == 5


def test_much_damping_on_little_inertia_needs_steps_that_do_not_grow() -> None:
    brake = "{spring: rigid, motor: {inertia: 1.0e-4, viscous_friction: 1.0}}"  # 1e4 1/s
    data = {"name": "brake", "bodies": [{"directions": {"ry": yaml.safe_load(brake)}}], "controlled": "j"}
    robot = robot_from_data({**data, "outputs": {"j": {"coordinates": ["body_1.ry"]}}}, "brake.yaml")
    assert substeps(robot, 0.004) == substeps(robot, 0.004, fast=True) == 16


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
    monkeypatch.setattr(compiled_plant, "substeps", lambda *_, **__: 16)
    assert usual == pytest.approx(squares(), abs=0.1 * np.sqrt(2 * data.n_values))
