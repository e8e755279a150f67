"""Controllers for robots without one: stable on every robot, decay as in a simulation, refusal."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.base import control_law
from flexros.control.context import LoopContext
from flexros.errors import InputError
from flexros.identify.design.decay import slowest_decay
from flexros.identify.design.default_controller import default_controller
from flexros.robot import load_robot, robot_names
from flexros.robot.linear.linearise import linear_model


@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_loop_of_every_robot_decays(name: str) -> None:
    robot = load_robot(name)
    law = default_controller(robot, robot.sample_time)
    assert slowest_decay(linear_model(robot), law, LoopContext(robot, robot.sample_time), robot.delay) > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 7e-4, 1e-3, 2.7e-3])
def test_decay_is_that_of_a_simulated_loop(delay: float) -> None:
    """two_mass under PD, 20 samples of 1 ms apart: the envelope of the motor position falls as predicted."""
    robot = load_robot("two_mass").with_values({"delay": delay})
    linear = linear_model(robot)
    law = control_law({"kind": "pid", "kp": 3e4, "kd": 500.0})
    decay = slowest_decay(linear, law, LoopContext(robot, 1e-3), delay)
    A, B, C, _ = linear.matrices()
    whole = int(delay / 1e-3 + 1e-9)
    x, line, error_before = np.array([0.0, 1e-3, 0, 0]), [0.0] * 4, -1e-3
    envelope = []
    for _ in range(3000):
        error = -float(C[0] @ x)
        torque = 3e4 * error + 500.0 * (error - error_before) / 1e-3
        error_before = error
        line = [torque, *line[:-1]]
        late = delay - whole * 1e-3
        for share, u in ((late, line[whole + 1]), (1e-3 - late, line[whole])):
            for _ in range(4 if share > 0 else 0):  # Runge-Kutta would do; Taylor of order 6 is exact enough
                term, h = x, share / 4
                x = x.copy()
                for order in range(1, 7):
                    term = (A @ term + (B[:, 0] * u if order == 1 else 0)) * h / order
                    x = x + term
        envelope.append(np.linalg.norm(x * [1, 1, 0.01, 0.01]))
    envelope = np.maximum.accumulate(np.array(envelope)[::-1])[::-1]
    first, last = 1000, 2500
    assert decay == pytest.approx(np.log(envelope[first] / envelope[last]) / (last - first) / 1e-3, rel=0.05)


def test_instability_is_seen() -> None:
    robot = load_robot("two_mass")
    wild = control_law({"kind": "pid", "kp": 3e6, "kd": 5e4})
    assert slowest_decay(linear_model(robot), wild, LoopContext(robot, 1e-3), 0.0) < 0


def test_hopeless_sample_time_is_refused() -> None:
    with pytest.raises(InputError, match="no PID controller holds robot two_mass .* sample time of 40 s"):
        default_controller(load_robot("two_mass"), 40.0)
