"""Closed-loop poles of the model-based laws where theory predicts them."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.control.computed_torque import ComputedTorque
from flexros.control.feedback_linearisation import FeedbackLinearisation
from flexros.control.quasi_static_linearisation import QuasiStaticLinearisation
from flexros.control.state_feedback import StateFeedback
from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model
from tests.control.loop_contexts import closed_loop_matrix, undamped


def polynomial(*roots: complex) -> np.ndarray:
    return np.real(np.poly(np.array(roots)))


@pytest.mark.parametrize("position", [[0.2, 0.3], [0.9, -0.8]])
def test_feedback_linearisation_has_the_same_poles_in_every_position(position: list[float]) -> None:
    law = FeedbackLinearisation(bandwidth=(20.0, 30.0))
    A = closed_loop_matrix(law, law.context(undamped("elbow"), 5e-4), position)
    scale = 25.0 ** np.arange(9)
    assert np.real(np.poly(A)) / scale == pytest.approx(polynomial(*[-20.0] * 4, *[-30.0] * 4) / scale, rel=1e-5)


def test_dampers_that_it_neglects_move_the_poles() -> None:
    law = FeedbackLinearisation(bandwidth=20.0)
    A = closed_loop_matrix(law, law.context(load_robot("elbow"), 5e-4), [0.2, 0.3])
    assert np.max(np.abs(np.linalg.eigvals(A) + 20.0)) > 1.0


def test_quasi_static_linearisation_of_one_axis() -> None:
    robot, w, motor_w = undamped("two_mass"), 20.0, 50.0
    law = QuasiStaticLinearisation(bandwidth=w, motor_bandwidth=motor_w)
    A = closed_loop_matrix(law, law.context(robot, 1e-3), [0.0])
    ratio = robot.parameters["body_1.rz.stiffness"].value / robot.parameters["body_1.inertia.zz"].value
    wanted = np.polymul([1, 2 * w, w**2], [1, 2 * motor_w, motor_w**2 + ratio])
    assert np.real(np.poly(A)) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("position", [[0.2, 0.3], [0.9, -0.8]])
def test_quasi_static_linearisation_of_the_elbow(position: list[float]) -> None:
    law = QuasiStaticLinearisation(bandwidth=(20.0, 30.0), motor_bandwidth=50.0)
    poles = np.linalg.eigvals(closed_loop_matrix(law, law.context(undamped("elbow"), 5e-4), position))
    for bandwidth in (20.0, 30.0):  # the double poles of the links
        assert np.sort(np.abs(poles + bandwidth))[1] < 0.05 * bandwidth
    assert np.max(poles.real) < -19.0


def test_state_feedback_has_the_poles_of_its_gains() -> None:
    robot = load_robot("two_mass")
    gains = {"motor_position": 5e4, "motor_speed": 900.0, "link_position": -1e4, "link_speed": 200.0}
    law = StateFeedback.model_validate(gains)
    A, B, *_ = linear_model(robot).matrices()
    K = np.array([[gains["link_position"], gains["motor_position"], gains["link_speed"], gains["motor_speed"]]])
    found = np.linalg.eigvals(closed_loop_matrix(law, law.context(robot, 1e-3), [0.0]))
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.linalg.eigvals(A - B @ K)), rel=1e-8)


def test_computed_torque_makes_each_axis_a_double_integrator() -> None:
    robot = load_robot("elbow")
    law = ComputedTorque(kp=400.0, kd=40.0)
    context = law.context(robot, 5e-4)
    c, r, y, g = law.function(context).sx_in()
    u = law.function(context)(c, r, y, g)[0]
    command = casadi.Function("u", [c, r, y, g], [u])
    q, e, before = np.array([0.4, -0.2]), np.array([1e-3, -2e-3]), np.array([1.05e-3, -2.1e-3])
    reference = np.zeros(context.references.size)
    reference[context.references.rows("motor_position")] = q + e
    state = np.concatenate([before, np.zeros(2), [1.0]])
    found = command(state, reference, q, law.gains(context)).full().ravel()
    rate = (e - before) / 5e-4
    arm = robot.model.arm_inverse_dynamics(q, -rate, 400 * e + 40 * rate, []).full().ravel()
    wanted = arm + np.array([60.0, 25.0]) * (400 * e + 40 * rate) - np.array([60.0, 30.0]) * rate
    assert found == pytest.approx(wanted, rel=1e-10)
