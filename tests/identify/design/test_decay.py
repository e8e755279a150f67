"""Decay of loops: one position as many, robots with stiff gears too."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import control_law
from flexros.identify.design.decay import decays_at, slowest_decay
from flexros.robot import load_robot
from flexros.robot.linearise import linear_model


@pytest.mark.parametrize("name", ["e12", "emps", "four_mass_linear"])
def test_decays_at_positions_are_those_of_their_linear_models(name: str) -> None:
    robot = load_robot(name)
    law = control_law({"kind": "pid", "kp": 2e3, "kd": 200.0})
    motors = robot.equilibrium()[list(robot.chain.motor_places)][None]
    expected = slowest_decay(linear_model(robot), law, robot.sample_time, robot.delay)
    assert decays_at(robot, motors, law, robot.sample_time) == pytest.approx([expected], rel=1e-6)


def test_progress_counts_positions() -> None:
    robot, told = load_robot("e12"), []
    motors = np.tile([0.0, 0.3], (200, 1))
    decays_at(robot, motors, control_law({"kind": "pid", "kp": 2e3, "kd": 200.0}), 5e-4, told.append)
    assert told == [128, 200]
