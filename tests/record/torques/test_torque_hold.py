"""Command held from each sampling instant to the next."""

from __future__ import annotations

import numpy as np

from flexros.record.torques.torque_hold import HeldCommands


def test_command_is_held_until_the_next() -> None:
    held = HeldCommands.of(np.array([20, 30, 60]), np.array([0, 10, 20, 29, 30, 50, 60, 70]))
    np.testing.assert_array_equal(held.row, [-1, -1, 0, 0, 1, 1, 2, 2])
    assert held.first == 2
    np.testing.assert_array_equal(held.values(np.array([1.0, 2.0, 3.0])), [1, 1, 1, 1, 2, 2, 3, 3])
    assert held.values(np.ones((3, 2))).shape == (8, 2)


def test_first_is_the_number_of_measurements_where_no_command_came_before() -> None:
    assert HeldCommands.of(np.array([100]), np.array([0, 10, 20])).first == 3
    assert HeldCommands.of(np.array([0, 10]), np.array([0, 10, 20])).first == 0
