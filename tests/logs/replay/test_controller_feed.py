"""The recorded reference as chunks ahead of time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.messages.joint_trajectory import read_joint_trajectory
from flexros.logs.replay.controller_feed import CHUNK, LEAD, controller_feed
from flexros.logs.write_log import write_log


def test_chunks_are_the_recorded_reference_in_every_bit(tmp_path: Path, make_log: Any) -> None:
    log = make_log(2 * CHUNK + 50)
    write_log(log, tmp_path / "log")
    feed = controller_feed(tmp_path / "log")
    chunks = [read_joint_trajectory(chunk.payload) for chunk in feed.chunks]
    assert [len(chunk.time_from_start) for chunk in chunks] == [CHUNK, CHUNK, 50]
    reference = log.joint_reference
    stamps = np.concatenate([chunk.stamp_ns + chunk.time_from_start for chunk in chunks])
    np.testing.assert_array_equal(stamps, reference.stamp)
    for ours, theirs in (("positions", "position"), ("velocities", "velocity"), ("effort", "effort")):
        played = np.vstack([getattr(chunk, ours) for chunk in chunks])
        np.testing.assert_array_equal(played, getattr(reference, theirs))
    assert [chunk.last_stamp for chunk in feed.chunks] == reference.stamp[[CHUNK - 1, 2 * CHUNK - 1, -1]].tolist()
    assert feed.chunks[2].log_time == reference.stamp[2 * CHUNK] - LEAD


def test_recorded_commands_are_known_by_stamp(tmp_path: Path, make_log: Any) -> None:
    log = make_log(20)
    write_log(log, tmp_path / "log")
    feed = controller_feed(tmp_path / "log")
    assert feed.joint_names == log.joint_commands.names
    assert feed.commands[int(log.joint_commands.stamp[7])] == tuple(log.joint_commands.effort[7])


def test_a_log_without_reference_feeds_no_controller(tmp_path: Path, make_log: Any) -> None:
    write_log(replace(make_log(20), joint_reference=None), tmp_path / "log")
    with pytest.raises(InputError, match="has no positions on joint_reference"):
        controller_feed(tmp_path / "log")
