from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.time_series import JointSeries, PoseSeries

STAMP = np.arange(3, dtype=np.int64) + 10


def test_series_are_frozen():
    series = JointSeries(STAMP, ("a",))
    with pytest.raises(dataclasses.FrozenInstanceError):
        series.names = ("b",)


@pytest.mark.parametrize("field", ["position", "velocity", "effort"])
def test_wrong_shape_is_named(field):
    with pytest.raises(InputError, match=rf"JointSeries.{field} has shape \(3, 2\) .* allowed is \(3, 1\) and float64"):
        JointSeries(STAMP, ("a",), **{field: np.zeros((3, 2))})


def test_wrong_type_is_named():
    with pytest.raises(InputError, match=r"type float32, allowed is \(3, 1\) and float64"):
        JointSeries(STAMP, ("a",), np.zeros((3, 1), np.float32))


def test_stamps_must_be_integers():
    with pytest.raises(InputError, match="give nanoseconds as integers"):
        JointSeries(STAMP.astype(float), ("a",))


def test_every_stamp_needs_its_time_of_receipt():
    told = r"received has shape \(2,\) and type int64, allowed is \(3,\) and int64"
    with pytest.raises(InputError, match=f"JointSeries.{told}"):
        JointSeries(STAMP, ("a",), received=STAMP[:2])
    with pytest.raises(InputError, match=f"PoseSeries.{told}"):
        PoseSeries(STAMP, "base", np.zeros((3, 3)), np.zeros((3, 4)), received=STAMP[:2])


@pytest.mark.parametrize(("stamp", "row"), [([1, 2, 2], 2), ([3, 1, 2], 1)])
def test_stamps_must_increase(stamp, row):
    with pytest.raises(InputError, match=f"does not increase at row {row}; sort it and drop repeats"):
        JointSeries(np.array(stamp), ("a",))


def test_repeated_joint_name_is_refused():
    with pytest.raises(InputError, match="has a name twice"):
        JointSeries(STAMP, ("a", "a"))


def test_pose_needs_four_numbers_of_orientation():
    with pytest.raises(InputError, match=r"PoseSeries.orientation has shape \(3, 3\)"):
        PoseSeries(STAMP, "base", np.zeros((3, 3)), np.zeros((3, 3)))


def test_joints_until_a_stamp():
    series = JointSeries(np.array([10, 20, 30]), ("a",), position=np.array([[1.0], [2.0], [3.0]]))
    part = series.until(25)
    np.testing.assert_array_equal(part.stamp, [10, 20])
    np.testing.assert_array_equal(part.position, [[1.0], [2.0]])
    assert part.velocity is None
