"""A log as labelled arrays, tables and pictures."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.time_series import ImuSeries, JointSeries, Log, PoseSeries

STEP = 1_000_000


@pytest.fixture
def log() -> Log:
    """Return a log of two motors at 1 kHz, with its reference at every second stamp and other sensors."""
    stamp = 1_000_000_000 + STEP * np.arange(6)
    position = np.arange(12.0).reshape(6, 2)
    return Log(
        JointSeries(stamp, ("motor_1", "motor_2"), position=position),
        joint_commands=JointSeries(stamp, ("motor_1", "motor_2"), effort=-position),
        joint_reference=JointSeries(stamp[::2], ("motor_2", "motor_1"), position=position[::2, ::-1] + 0.5),
        tool_pose=PoseSeries(stamp, "base", np.ones((6, 3)), np.tile([0.0, 0, 0, 1], (6, 1))),
        other_series={"tool_imu": ImuSeries(stamp, "tool", acceleration=np.full((6, 3), 9.81))},
    )


def test_one_topic_has_plain_names_and_units(log: Log) -> None:
    dataset = log.to_xarray("joint_states")
    assert dataset.position.sel(joint="motor_2").sel(time=0.003, method="nearest") == 7.0
    assert dataset.position.attrs["units"] == "rad or m"
    assert log.to_xarray("tool_pose").position.attrs["units"] == "m"


def test_all_topics_share_the_time_and_lack_what_was_not_sampled(log: Log) -> None:
    dataset = log.to_xarray()
    assert dataset.sizes["time"] == 6
    assert dataset.joint_reference_position.sel(joint="motor_1").values[[0, 2]].tolist() == [0.5, 4.5]
    assert np.isnan(dataset.joint_reference_position.sel(joint="motor_1").values[1])
    assert dataset.tool_imu_acceleration.sel(axis="z").values[0] == 9.81


def test_table_has_a_column_per_quantity_and_joint(log: Log) -> None:
    frame = log.to_pandas()
    assert frame["joint_states.position.motor_1"].iloc[-1] == 10.0
    assert frame.index[-1] == pytest.approx(5e-3)
    assert list(log.to_pandas("joint_commands").columns) == ["effort.motor_1", "effort.motor_2"]


def test_topic_that_was_not_recorded_is_refused(log: Log) -> None:
    with pytest.raises(InputError, match="tool_reference"):
        log.to_xarray("tool_reference")
    with pytest.raises(InputError, match="joint_states"):
        log.to_pandas("joint_state")


def test_picture_draws_error_of_the_right_joint(log: Log) -> None:
    error = [curve for curve in log.plot().data if curve.yaxis == "y3" and curve.name == "motor_1"]
    assert np.asarray(error[0].y)[0] == pytest.approx(500.0)  # mrad


def test_notebook_lists_topics(log: Log) -> None:
    assert "tool_imu" in log._repr_html_()
    assert repr(log) == "<Log: 2 motors, 6 samples, 0.005 s>"
