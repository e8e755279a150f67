"""States of rest for many parameters equal those of robots built one by one."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.equilibrium_search import EquilibriumSearch


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("elbow", {"body_2.mass": 80.0, "body_1.ry.stiffness": 1.5e5}),
        ("six_axis", {"body_7.mass": 250.0, "body_3.rx.stiffness": 1e6}),
        ("e12", {"body_3.mass": 250.0}),
        ("four_mass", {"body_2.rz.stiffness": 100.0}),
        ("emps", {"body_1.mass": 80.0}),
    ],
)
def test_rest_equals_that_of_the_robot_itself(name: str, values: dict[str, float]) -> None:
    robot = load_robot(name)
    near = robot.equilibrium()[: robot.n_coordinates]
    motors = robot.model.encoder(near).full().ravel()
    other = robot.with_values(values)
    expected = other.equilibrium(motor_position=motors)
    rest = EquilibriumSearch(robot.symbolic(tuple(values))).find(near, np.array(list(values.values())))
    np.testing.assert_allclose(rest.state, expected, atol=1e-12)
    np.testing.assert_allclose(rest.torque, other.holding_torque(expected), atol=1e-6)


def test_held_gears_stand_still_and_held_motors_too() -> None:
    robot = load_robot("elbow")
    q = np.array([0.2, 0.3, 0.2, 0.3])
    none = np.zeros(0)
    np.testing.assert_array_equal(EquilibriumSearch(robot.model, "gears").find(q, none).state[:2], q[:2])
    np.testing.assert_array_equal(EquilibriumSearch(robot.model, "motors").find(q, none).state[2:4], q[2:])


def test_search_does_not_jump_to_a_distant_equilibrium() -> None:
    """A shoulder far too soft: the arm falls, for a robot of its own as for one of many."""
    robot = load_robot("elbow")
    near, soft = robot.equilibrium(), {"body_1.ry.stiffness": 500.0}
    with pytest.raises(InputError, match="has no equilibrium at motor positions"):
        robot.with_values(soft).equilibrium(motor_position=near[2:4])
    with pytest.raises(InputError, match=r"has no equilibrium with body_1\.ry\.stiffness = 500"):
        EquilibriumSearch(robot.symbolic(tuple(soft))).find(near[:4], np.array([500.0]))


def test_values_without_equilibrium_are_reported() -> None:
    robot = load_robot("elbow")
    search = EquilibriumSearch(robot.symbolic(("body_1.ry.stiffness",)))
    with pytest.raises(InputError, match=r"robot elbow has no equilibrium with body_1\.ry\.stiffness = nan"):
        search.find(robot.equilibrium()[:4], np.array([np.nan]))


def test_parameters_that_do_not_move_the_equilibrium_need_no_new_search(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load_robot("elbow")
    names = ("body_2.mass", "motor_1.inertia")
    search = EquilibriumSearch(robot.symbolic(names))
    near = robot.equilibrium()[: robot.n_coordinates]
    mass, inertia = (robot.parameters[name].value for name in names)
    first = search.find(near, np.array([mass, inertia]))
    heavy = search.find(near, np.array([1.1 * mass, inertia]))
    assert not np.array_equal(first.state, heavy.state)
    monkeypatch.setattr(search, "_evaluate", None)
    again = search.find(near, np.array([mass, 2.0 * inertia]))
    np.testing.assert_array_equal(again.state, first.state)
    assert not np.shares_memory(again.state, first.state)
