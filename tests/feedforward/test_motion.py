from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.motion import Motion, Reference


def motion(n: int) -> Motion:
    rows = np.arange(2.0 * n).reshape(n, 2)
    return Motion(rows, rows + 0.1, rows + 0.2, rows + 0.3, rows + 0.4, rows + 0.5)


def test_chunks_joined_are_the_whole() -> None:
    whole = motion(10)
    first, *others = whole.chunks(4)
    assert [len(part) for part in (first, *others)] == [4, 4, 2]
    for part in others:
        first = first.joined(part)
    np.testing.assert_array_equal(first.torque, whole.torque)
    np.testing.assert_array_equal(first.momentum, whole.momentum)


def test_friction_adds_to_torque_and_load_alone() -> None:
    rubbing, plain = motion(3).with_friction(np.ones((3, 2))), motion(3)
    np.testing.assert_array_equal(rubbing.torque, plain.torque + 1)
    np.testing.assert_array_equal(rubbing.load, plain.load + 1)
    np.testing.assert_array_equal(rubbing.momentum, plain.momentum)


def test_rows_of_a_reference_must_match() -> None:
    rows = np.zeros((3, 2))
    with pytest.raises(ValueError, match=r"number of rows, but have .*'torque': 2"):
        Reference(np.zeros(3), rows, rows, rows[:2], rows, np.zeros((3, 7)))
