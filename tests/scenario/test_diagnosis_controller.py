"""The controller that a diagnosis has when its scenario names none."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.control.pid import Pid
from flexros.errors import InputError
from flexros.identify.design.default_controller import default_controller
from flexros.robot import load_robot
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow


def test_it_is_made_for_the_robot_of_the_scenario() -> None:
    scenario = load_scenario("diagnosis")
    for name in ("four_mass_linear", "e12"):
        robot = load_robot(name)
        assert scenario.with_values({"robot": name}).controller == default_controller(robot, robot.sample_time)


def test_it_is_made_for_the_sample_time_of_the_scenario() -> None:
    scenario = load_scenario("diagnosis").with_values({"sample_time": 1e-3})
    assert isinstance(scenario.controller, Pid)
    assert scenario.controller.derivative_filter == 2e-3


def test_one_that_is_given_stays() -> None:
    scenario = load_scenario("diagnosis").with_values({"controller": {"kind": "pid", "kp": 20, "kd": 2}})
    assert scenario.with_values({"robot": "four_mass"}).controller == Pid(kp=20, kd=2)


def test_a_patch_has_that_of_its_robot(tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: four_mass\neffects:\n- {effect: coulomb_friction, location: motor_1, parameters: {level: 0.1}}\n"
    )
    robot = load_robot("four_mass")
    scenario = load_scenario("diagnosis").with_values({"robot": str(patch)})
    assert scenario.controller == default_controller(robot, robot.sample_time)


def test_unknown_robot_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="unknown robot 'e13'"):
        load_scenario("diagnosis").with_values({"robot": "e13"})
