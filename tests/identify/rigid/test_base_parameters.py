"""Base parameters of the built-in robots."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.base_parameters import base_parameters, independent_columns
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.robot import load_robot, robot_names


@pytest.mark.parametrize("name", [name for name in robot_names() if name != "flexible_arm"])  # its links bend
def test_base_parameters_span_all_torques_and_no_fewer_would_do(name: str) -> None:
    robot = load_robot(name)
    regressor = RigidRegressor(robot)
    base = base_parameters(regressor, robot.n_motors)
    H = regressor.matrix(*np.random.default_rng(8).normal(size=(3, 200, robot.n_motors)))
    H = H.reshape(-1, H.shape[2])
    size = np.linalg.norm(H, axis=0)
    scaled = H[:, size > 1e-9 * size.max()] / size[size > 1e-9 * size.max()]
    singular = np.linalg.svd(scaled, compute_uv=False)
    assert np.count_nonzero(singular > 1e-9 * singular[0]) == len(base.leading)
    np.testing.assert_allclose(H[:, base.leading] @ base.combination, H, atol=1e-9 * size.max())


def test_base_parameters_of_the_elbow_are_those_of_the_textbook(elbow) -> None:
    base = base_parameters(RigidRegressor(elbow), 2)
    assert len(base.names) == 13
    first = base.names.index("body_1.inertia_at_joint.yy")
    assert base.parts(first) == pytest.approx(
        {"body_1.inertia_at_joint.yy": 1, "motor_1.inertia": 1, "body_2.mass": 0.81}
    )
    assert base.words(first) == (
        "inertia yy of body_1 at its joint + inertia of motor_1 at the arm + 0.81 mass of body_2"
    )
    assert base.nominal[first] == pytest.approx(4 + 60 * 0.16 + 60 + 45 * 0.81)
    assert base.units[first] == "kg m2"
    moment = base.names.index("body_1.first_moment.z")
    assert base.parts(moment) == pytest.approx({"body_1.first_moment.z": 1, "body_2.mass": 0.9})
    assert "body_1.mass" in base.without_effect


def test_a_difference_in_words() -> None:
    robot = load_robot("six_axis")
    base = base_parameters(RigidRegressor(robot), 6)
    assert any(" - " in base.words(place) for place in range(len(base.names)))


def test_columns_are_chosen_in_their_order() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 30))
    assert independent_columns(np.column_stack([np.zeros(30), a, 2 * a, b, a - b]), 1e-8) == [1, 3]


def test_nearly_dependent_column_by_the_share_that_is_left() -> None:
    a, b = np.eye(30)[:2]
    matrix = np.column_stack([a, a + 0.01 * b])
    assert independent_columns(matrix, 0.02) == [0]
    assert independent_columns(matrix, 0.005) == [0, 1]
