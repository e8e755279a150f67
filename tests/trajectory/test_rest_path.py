"""Motion that is none."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.trajectory.rest_path import Rest
from flexros.trajectory.trajectory import Trajectory

POINT = np.array([0.3, -0.7])


def test_stays_for_all_times_with_all_derivatives_zero() -> None:
    motion = Trajectory.at_rest(POINT).evaluate(np.array([-1.0, 0.0, 0.5, 1.0, 1e6]))
    assert motion.shape == (5, 5, 2)
    assert np.array_equal(motion[0], np.tile(POINT, (5, 1)))
    assert not motion[1:].any()


def test_place_is_the_point_without_a_way() -> None:
    place = Trajectory.at_rest(POINT).place(0.25)
    assert str(place) == "t = 0.2500 s, 0.0 % of move 1 (path parameter 0), point (0.3, -0.7)"


def test_belongs_to_the_joints_unless_another_output_is_named() -> None:
    assert Trajectory.at_rest(POINT).joints
    assert Trajectory.at_rest(POINT, "tool").output == "tool"


def test_has_no_length() -> None:
    path = Rest(POINT)
    assert (path.extent, path.pace, path.coordinate_pace.tolist()) == (0.0, 0.0, [0.0, 0.0])
    assert np.array_equal(path.end, POINT)


def test_point_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InputError, match="the point of rest is .*nan.*, allowed are finite numbers"):
        Trajectory.at_rest(np.array([np.nan]))
