"""The simplified flexible-joint model: exact derivatives on undamped robots, and which robots it refuses."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.control.feedback_linearisation import linearising_torque
from flexros.control.model.flexible_joints import FlexibleJointModel, LinkStates
from flexros.control.observers.base import Estimate
from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.robot.robot import LIBRARY, robot_from_data
from tests.control.loop_contexts import undamped


def cubic_elbow() -> Robot:
    data = dict(read_yaml(LIBRARY / "elbow.yaml"))
    for body, linear in zip(data["bodies"], (1e5, 6e4), strict=True):
        body["directions"]["ry"] |= {"spring": {"cubic": {"linear": linear, "cubic": 4e9}}, "damper": 0.0}
    return robot_from_data(data, "test.yaml")


def derivatives_of_the_links(robot: Robot, u: casadi.SX, x: casadi.SX) -> list[casadi.SX]:
    """Differentiate the link positions of the plant four times along its flow, with the torque held."""
    held = casadi.SX.sym("held", robot.n_motors)
    rate = robot.model.derivative(x, held, casadi.SX.zeros(6), casadi.SX(0, 1))
    found = [x[: robot.n_arm]]
    for _ in range(4):
        found.append(casadi.jtimes(found[-1], x, rate))
    return [casadi.substitute(value, held, u) for value in found]


@pytest.mark.parametrize("robot", [undamped("elbow"), cubic_elbow()], ids=["linear", "cubic"])
def test_links_are_chains_of_four_integrators(robot: Robot) -> None:
    x, snap = casadi.SX.sym("x", 8), casadi.SX.sym("snap", 2)
    estimate = Estimate(x[2:4], x[6:8], x[:2], x[4:6])
    u = linearising_torque(FlexibleJointModel(robot), estimate, snap)
    *_, fourth = derivatives_of_the_links(robot, u, x)
    random = np.random.default_rng(5)
    state = robot.equilibrium([0.3, -0.5]) + np.array([0, 0, 1e-3, -2e-3, 0.3, -0.5, 0.4, -0.45]) * random.uniform(
        0.5, 1, 8
    )
    wanted = np.array([1500.0, -2300.0])
    found = casadi.Function("fourth", [x, snap], [fourth])(state, wanted).full().ravel()
    assert found == pytest.approx(wanted, rel=1e-7)


def test_acceleration_and_jerk_follow_from_measured_positions_and_speeds() -> None:
    robot, x = cubic_elbow(), casadi.SX.sym("x", 8)
    links = FlexibleJointModel(robot).measured_links(x[2:4], x[6:8], x[:2], x[4:6])
    _, _, second, third, _ = derivatives_of_the_links(robot, casadi.SX([10.0, -5.0]), x)
    evaluate = casadi.Function("links", [x], [links.acceleration, links.jerk, second, third])
    state = np.array([0.3, -0.5, 0.302, -0.501, 0.4, 0.2, 0.42, 0.15])
    acceleration, jerk, wanted_acceleration, wanted_jerk = (part.full().ravel() for part in evaluate(state))
    assert acceleration == pytest.approx(wanted_acceleration, rel=1e-9)
    assert jerk == pytest.approx(wanted_jerk, rel=1e-8)


def test_the_wanted_deflection_moves_the_links() -> None:
    robot = cubic_elbow()
    model, parts = FlexibleJointModel(robot), [casadi.SX.sym(name, 2) for name in "qvajs"]
    gear = model.gear_motion(LinkStates(*parts[:4]), parts[4])
    numbers = np.random.default_rng(6).standard_normal((5, 2)) * np.array([[0.5], [1], [3], [30], [300]])
    evaluate = casadi.Function("gear", parts, [model.spring_torque(gear.deflection), model.load(*parts[:3])])
    carried, load = (part.full().ravel() for part in evaluate(*numbers))
    assert carried == pytest.approx(load, rel=1e-9)
    along = casadi.Function("d", parts, [gear.deflection, gear.rate, gear.acceleration])
    step = 1e-4
    taylor = [sum(numbers[j + k] * step**j / [1, 1, 2, 6, 24][j] for j in range(5 - k)) for k in range(5)]
    back = [sum(numbers[j + k] * (-step) ** j / [1, 1, 2, 6, 24][j] for j in range(5 - k)) for k in range(5)]
    after, before, now = (along(*point)[0].full().ravel() for point in (taylor, back, numbers))
    rate, second = (along(*numbers)[order].full().ravel() for order in (1, 2))
    assert (after - before) / (2 * step) == pytest.approx(rate, rel=1e-5)
    assert (after - 2 * now + before) / step**2 == pytest.approx(second, rel=1e-3)


@pytest.mark.parametrize(("name", "text"), [("e12", "body_3.ry"), ("emps", "motor_1")])
def test_other_robots_are_refused(name: str, text: str) -> None:
    with pytest.raises(InputError, match=text):
        FlexibleJointModel(load_robot(name))
