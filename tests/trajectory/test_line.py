from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.trajectory.line import JointMove, Line


def test_line_is_parametrised_by_its_length() -> None:
    line = Line(np.array([0.0, 0.0]), np.array([3.0, 4.0]))
    assert line.extent == 5.0
    assert line.parameter_unit == "m"
    np.testing.assert_allclose(line.derivatives(np.array([2.5]))[:2, 0], [[1.5, 2.0], [0.6, 0.8]])


def test_line_meets_start_and_end_exactly() -> None:
    line = Line(np.array([0.1, 0.2, 0.3]), np.array([1.7, -0.9, 0.7]))
    np.testing.assert_array_equal(line.start, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(line.end, [1.7, -0.9, 0.7])


def test_turn_on_the_spot_is_parametrised_by_its_angle() -> None:
    line = Line(np.zeros(6), np.array([0.0, 0.0, 0.0, 0.0, 0.3, 0.4]))
    assert line.extent == 0.5
    assert line.parameter_unit == "rad"


def test_length_counts_positions_only() -> None:
    assert Line(np.zeros(3), np.array([3.0, 4.0, 1.0]), n_position=2).extent == 5.0


def test_line_without_length_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"starts and ends at \(1, 2\) so its length is 0 m, allowed .* give another end"
    ):
        Line(np.array([1.0, 2.0]), np.array([1.0, 2.0]))


def test_joint_move_has_one_parameter_from_0_to_1() -> None:
    move = JointMove(np.array([1.0, -1.0]), np.array([2.0, 3.0]))
    np.testing.assert_allclose(move.derivatives(np.array([0.0, 0.5, 1.0]), 0)[0], [[1, -1], [1.5, 1], [2, 3]])
    np.testing.assert_array_equal(move.coordinate_pace, [1.0, 4.0])


def test_joint_move_without_motion_is_refused() -> None:
    with pytest.raises(InputError, match="no joint moves, allowed is a move of at least one joint; give another end"):
        JointMove(np.array([1.0, 2.0]), np.array([1.0, 2.0]))
