"""Linear closed loop, line by line."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.cascade import Cascade
from flexros.control.context import LoopContext
from flexros.control.controller import Controller
from flexros.control.pid import Pid
from flexros.identify.experiment.closed_loop_response import controller_response, loop_response
from flexros.robot import load_robot

T = 1e-3
CONTEXT = LoopContext(load_robot("two_mass"), T)
LAWS = [
    Pid(kp=100.0, ki=20.0, kd=5.0, derivative_filter=2e-3),
    Cascade(position_gain=10.0, speed_gain=8.0, integral_gain=30.0, speed_filter=1e-3),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_response_of_a_controller_is_that_of_its_samples(law: Pid | Cascade) -> None:
    frequency, n = 8.0, 125
    angle = 2.0 * np.pi * frequency * T * np.arange(40 * n)
    inputs = [np.cos(angle + phase) * size for phase, size in ((0.0, 1.0), (0.7, 20.0), (0.3, 2.0))]
    controller = Controller(law, CONTEXT)
    u = np.array([controller.step([y], [x, v, 0.0]) for x, v, y in zip(*inputs, strict=True)])
    response = controller_response(law, CONTEXT, np.array([frequency]))
    wanted = np.array([1.0, 20.0 * np.exp(0.7j)]) @ response.to_reference[0, 0]
    wanted += 2.0 * np.exp(0.3j) * response.to_measured[0, 0, 0]
    found = 2.0 * np.mean(u[-8 * n :, 0] * np.exp(-1j * angle[-8 * n :]))
    assert found == pytest.approx(wanted, rel=1e-6)


def test_integral_action_asks_for_no_torque_to_stay_elsewhere() -> None:
    robot, law = load_robot("two_mass"), LAWS[0]
    slow = np.array([1e-4])
    response = loop_response(robot, robot.home, controller_response(law, CONTEXT, slow), T, slow)
    assert abs(response.torque[0, 0, 0]) < 1e-4  # two_mass has no gravity: a new place needs no torque
