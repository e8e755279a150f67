from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from flexros.errors import InputError
from flexros.trajectory.line import Line
from flexros.trajectory.orientation import RollPitchYaw, quaternion, quaternion_of, rotation_vectors

FIRST = Rotation.from_euler("xyz", [0.3, 0.2, -0.5])
LAST = Rotation.from_euler("xyz", [-0.8, 0.6, 1.2])


def test_line_turns_as_slerp() -> None:
    vector = rotation_vectors(FIRST.as_quat(), [LAST.as_quat()])[0]
    path = RollPitchYaw(Line(np.zeros(6), np.concatenate(([2.0, 0.0, 0.0], vector))), FIRST.as_quat())
    s = np.linspace(0.0, 2.0, 21)
    expected = Slerp([0.0, 2.0], Rotation.concatenate([FIRST, LAST]))(s).as_euler("xyz")
    np.testing.assert_allclose(path.derivatives(s, 0)[0, :, 3:], expected, atol=1e-14)


def test_angles_are_those_of_robot_outputs() -> None:
    path = RollPitchYaw(Line(np.zeros(6), np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])), FIRST.as_quat())
    R = FIRST.as_matrix()
    expected = [
        np.arctan2(R[2, 1], R[2, 2]),
        np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0])),
        np.arctan2(R[1, 0], R[0, 0]),
    ]
    np.testing.assert_allclose(path.start[3:], expected, atol=1e-15)


def test_full_turns_keep_their_precision() -> None:
    path = RollPitchYaw(Line(np.zeros(6), np.array([1.0, 0, 0, 0, 0, 2.0 * np.pi])), np.array([0.0, 0.0, 0.0, 1.0]))
    np.testing.assert_allclose(path.derivatives(np.array([1.0]))[:, 0, 5], [0.0, 2.0 * np.pi, 0, 0, 0], atol=1e-9)


def test_pitch_of_90_degrees_is_refused_with_its_parameter() -> None:
    path = RollPitchYaw(Line(np.zeros(6), np.array([1.0, 0, 0, 0, np.pi, 0])), np.array([0.0, 0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"pitch of the tool is 90 degrees at path parameter 0.5 m, .* choose another"):
        path.derivatives(np.array([0.0, 0.5]))


def test_rotation_vectors_do_not_jump_by_a_full_turn() -> None:
    angles = np.linspace(0.0, 3.5, 8)
    vectors = rotation_vectors(np.array([0.0, 0, 0, 1.0]), [Rotation.from_rotvec([0, a, 0]).as_quat() for a in angles])
    np.testing.assert_allclose(vectors[:, 1], angles, atol=1e-12)


def test_quaternion_of_roll_pitch_yaw() -> None:
    np.testing.assert_allclose(quaternion_of(np.array([0.3, 0.2, -0.5])), FIRST.as_quat())


@pytest.mark.parametrize("values", [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0, 0.0]])
def test_no_quaternion_is_refused(values: list[float]) -> None:
    with pytest.raises(
        InputError, match=r"the end_orientation is \(.*\), allowed is a quaternion .* of size 1; correct"
    ):
        quaternion(values, "end_orientation")


def test_rounded_quaternion_is_made_unit() -> None:
    assert np.linalg.norm(quaternion([0.7071, 0.0, 0.0, 0.7071], "q")) == pytest.approx(1.0, abs=1e-15)
