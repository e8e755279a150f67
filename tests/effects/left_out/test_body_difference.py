"""Numbers of a body that differ from those of the robot file."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.tool_load import body_numbers
from flexros.errors import InputError
from flexros.robot import load_robot


def test_differences_are_added_to_the_numbers_of_the_body() -> None:
    robot = load_robot("elbow")
    mass, center, inertia = body_numbers(robot, "body_2")
    changed = BodyDifference(mass=-0.5, x=0.02, zz=0.01).changed(robot, "body_2")
    new_mass, new_center, new_inertia = body_numbers(changed, "body_2")
    assert new_mass == pytest.approx(mass - 0.5)
    np.testing.assert_allclose(new_center - center, [0.02, 0.0, 0.0], atol=1e-15)
    expected = np.zeros((3, 3))
    expected[2, 2] = 0.01
    np.testing.assert_allclose(new_inertia - inertia, expected, atol=1e-15)
    assert changed.parameters["body_1.mass"].value == robot.parameters["body_1.mass"].value


def test_no_difference_changes_nothing() -> None:
    robot = load_robot("elbow")
    assert BodyDifference().changed(robot, "body_1") is robot


def test_a_body_that_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match="body_difference"):
        BodyDifference(mass=-1e6).changed(load_robot("elbow"), "body_2")
