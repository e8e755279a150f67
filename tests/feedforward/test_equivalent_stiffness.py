from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward.equivalent_stiffness import equivalent_compliance, gear_compliance
from flexros.robot import Robot, load_robot
from tests.feedforward.cases import edited_robot


def test_stiffness_of_e12_at_the_start(e12: Robot) -> None:
    stiffness = 1.0 / equivalent_compliance(e12, e12.equilibrium())
    np.testing.assert_allclose(stiffness, [1e5, 97297.3], atol=0.05)
    assert 1.0 / stiffness[1] == pytest.approx(1e-5 + (0.2 / 1.2) ** 2 * 1e-5, rel=1e-12)


def test_tool_yields_statically_as_the_flexible_joint_model_says(e12: Robot) -> None:
    """A small force at the tool, motors held: the tool moves as with the equivalent gears alone."""
    state = e12.equilibrium()
    model, p = e12.model, e12.model.parameter_values
    q, force = state[:5].copy(), np.array([3.0, 0, -5.0])
    for _ in range(3):  # Newton on the arm's balance with the force at the tool
        balance = np.array(model.force(q, np.zeros(5), np.zeros(2), [*force, 0, 0, 0], p)).ravel()[:3]
        slope = np.array([
            np.array(model.force(q + e, np.zeros(5), np.zeros(2), [*force, 0, 0, 0], p)).ravel()[:3] - balance
            for e in 1e-7 * np.eye(5)[:3]
        ]).T / 1e-7  # fmt: skip
        q[:3] -= np.linalg.solve(slope, balance)
    moved = e12.forward_kinematics(q[:3]) - e12.forward_kinematics(state[:3])
    J = np.column_stack(
        [
            (e12.forward_kinematics(state[:3] + e) - e12.forward_kinematics(state[:3] - e)) / 2e-6
            for e in 1e-6 * np.eye(3)[:2]
        ]
    )
    expected = J @ (equivalent_compliance(e12, state) * (J.T @ force[[0, 2]]))
    np.testing.assert_allclose(moved, expected, rtol=1e-3)


def test_gears_alone_keep_their_stiffness() -> None:
    elbow = load_robot("elbow")
    compliance = equivalent_compliance(elbow, elbow.equilibrium())
    springs = [elbow.joints[place].direction.spring.stiffness.value for place in elbow.gear_rows]
    np.testing.assert_allclose(1.0 / compliance, springs, rtol=1e-12)


def test_given_stiffness_overrides(e12: Robot) -> None:
    compliance = gear_compliance(e12, e12.equilibrium(), "tool", {"motor_2": 5e4})
    np.testing.assert_allclose(1.0 / compliance, [1e5, 5e4])


def test_stiff_gears_have_no_compliance() -> None:
    emps = load_robot("emps")
    np.testing.assert_array_equal(gear_compliance(emps, emps.equilibrium(), "tool", {}), [0.0])


def test_unknown_motor(e12: Robot) -> None:
    with pytest.raises(InputError, match=r"unknown motor 'motor_3' in feedforward.stiffness: .*motor_1, motor_2"):
        gear_compliance(e12, e12.equilibrium(), "tool", {"motor_3": 1.0})


def test_spring_without_stiffness() -> None:
    def loosen(data: dict[str, list[dict[str, dict[str, dict[str, float]]]]]) -> None:
        data["bodies"][2]["directions"]["ry"]["spring"] = {"cubic": {"linear": 0.0, "cubic": 1e5}}  # type: ignore[dict-item]

    robot = edited_robot("e12", loosen)
    with pytest.raises(InputError, match=r"direction body_3.ry of robot e12 has no stiffness at the start"):
        equivalent_compliance(robot, robot.equilibrium())
