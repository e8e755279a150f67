"""Chunks of a reference read point by point, compared with the reader of whole trajectories."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_trajectory import (
    JointTrajectoryChunk,
    read_joint_trajectory,
    serialise_joint_trajectory,
)
from flexros.logs.messages.trajectory_rows import TrajectoryRows
from flexros.logs.stamps import START_NS

T = 5e-4
STEP = 500_000


def chunk(joints: int, n: int, frame: str = "") -> JointTrajectoryChunk:
    position, velocity, effort = np.random.default_rng(joints).normal(size=(3, n, joints))
    names = tuple(f"motor_{number + 1}" for number in range(joints))
    times = np.arange(n, dtype=np.int64) * STEP
    return JointTrajectoryChunk(START_NS, names, times, position, velocity, None, effort, frame)


@pytest.mark.parametrize("joints", [1, 2, 3, 6])
@pytest.mark.parametrize("frame", ["", "base", "tool0"])
def test_rows_are_those_of_the_whole_trajectory(joints: int, frame: str) -> None:
    given = chunk(joints, 7, frame)
    message = serialise_joint_trajectory(given)
    rows, whole = TrajectoryRows(message, given.names, T), read_joint_trajectory(message)
    assert (len(rows), rows.first, rows.last) == (7, START_NS, START_NS + 6 * STEP)
    for k in range(7):
        row = rows.row(START_NS + k * STEP)
        assert row is not None
        assert whole.positions is not None
        assert whole.velocities is not None
        assert whole.effort is not None
        np.testing.assert_array_equal(row, np.concatenate([whole.positions[k], whole.velocities[k], whole.effort[k]]))


@pytest.mark.parametrize("stamp", [START_NS - STEP, START_NS + 7 * STEP, START_NS + STEP // 2, START_NS + STEP + 1])
def test_stamp_without_a_point_has_no_row(stamp: int) -> None:
    given = chunk(2, 7)
    assert TrajectoryRows(serialise_joint_trajectory(given), given.names, T).row(stamp) is None


@pytest.mark.parametrize(
    "other",
    [
        replace(chunk(2, 7), velocities=None),
        replace(chunk(2, 7), accelerations=np.zeros((7, 2))),
        replace(chunk(2, 7), names=("motor_2", "motor_1")),
        replace(chunk(2, 7), time_from_start=np.arange(7) * 3 * STEP),
        JointTrajectoryChunk(START_NS, ("motor_1", "motor_2"), np.empty(0, np.int64)),
    ],
    ids=["no velocities", "accelerations", "order", "step", "no points"],
)
def test_other_forms_are_left_to_the_reader_of_whole_trajectories(other: JointTrajectoryChunk) -> None:
    with pytest.raises(MessageError):
        TrajectoryRows(serialise_joint_trajectory(other), ("motor_1", "motor_2"), T)


@pytest.mark.parametrize("cut", [13, 40, 60, 150])
def test_truncated_message_is_no_trajectory(cut: int) -> None:
    with pytest.raises(MessageError):
        TrajectoryRows(serialise_joint_trajectory(chunk(2, 7))[:-cut], ("motor_1", "motor_2"), T)


def test_point_that_is_not_a_number_or_has_other_fields_is_refused_when_it_is_used() -> None:
    given = chunk(2, 7)
    assert given.effort is not None
    given.effort[3, 1] = np.nan
    message = bytearray(serialise_joint_trajectory(given))
    rows = TrajectoryRows(bytes(message), given.names, T)
    assert rows.row(START_NS + 2 * STEP) is not None
    with pytest.raises(MessageError, match="not a finite number"):
        rows.row(START_NS + 3 * STEP)
    values = message.index(struct.pack("<d", given.positions[4, 0]))  # type: ignore[index]
    at = message.rindex(struct.pack("<I", 2), 0, values)  # the number of positions, perhaps before padding
    message[at : at + 4] = struct.pack("<I", 3)
    with pytest.raises(MessageError, match="differ in the fields"):
        TrajectoryRows(bytes(message), given.names, T).row(START_NS + 4 * STEP)
