from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mcap.reader import make_reader

from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.logs.time_series import JointSeries, Log
from flexros.logs.write_log import write_log
from flexros.logs.writer import MAX_CHUNK_DURATION


@pytest.mark.parametrize(("n", "n_joints"), [(1, 1), (50, 2), (2500, 6)])
def test_written_log_is_read_back_bit_by_bit(tmp_path, make_log, assert_same_log, n, n_joints):
    log = make_log(n, n_joints)
    write_log(log, tmp_path / "log")
    again = read_log(tmp_path / "log")
    assert_same_log(log, again)
    assert again.provenance == log.provenance
    assert again.warnings == ()
    assert again.other_topics == {}


def test_absent_topics_stay_absent(tmp_path, make_log, assert_same_log):
    log = dataclasses.replace(make_log(), joint_reference=None, tool_pose=None, tool_reference=None)
    write_log(log, tmp_path / "log")
    assert_same_log(log, read_log(tmp_path / "log"))


def test_messages_are_in_the_order_of_their_stamps(tmp_path, make_log):
    log = make_log(1500)
    slow = log.joint_reference
    slow = JointSeries(
        slow.stamp[::8], slow.names, *(getattr(slow, f)[::8] for f in ("position", "velocity", "effort"))
    )
    write_log(dataclasses.replace(log, joint_reference=slow), tmp_path / "log")
    with (tmp_path / "log" / "log_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        read = [(m.log_time, c.topic) for _, c, m in reader.iter_messages(log_time_order=False)]
        spans = [c.message_end_time - c.message_start_time for c in reader.get_summary().chunk_indexes]
    assert [time for time, _ in read] == sorted(time for time, _ in read)
    first = [topic for time, topic in read if time == 10**9]
    assert first == ["/joint_states", "/joint_commands", "/joint_reference", "/tool_pose", "/tool_reference"]
    assert max(spans) < MAX_CHUNK_DURATION


def test_times_of_receipt_are_written_as_log_times(tmp_path, make_log, assert_same_log):
    """Two messages arrive in the order opposite to that of their stamps, others up to 0.7 s late."""
    log = make_log(2000)
    late = np.linspace(0, 7 * 10**8, 2000).astype(np.int64) + 3_000
    late[100] += 1_000_000
    states = dataclasses.replace(log.joint_states, received=log.joint_states.stamp + late)
    pose = dataclasses.replace(log.tool_pose, received=log.tool_pose.stamp + late)
    log = dataclasses.replace(log, joint_states=states, tool_pose=pose)
    write_log(log, tmp_path / "log")
    again = read_log(tmp_path / "log")
    assert_same_log(log, again)
    assert again.warnings == tuple(
        f"/{name}: messages are not in the order of their stamps, they were sorted"
        for name in ("joint_states", "tool_pose")
    )


def test_special_numbers_survive(tmp_path):
    values = np.array([[np.nan, -0.0], [np.inf, 5e-324]])
    log = Log(JointSeries(np.array([10**9, 2 * 10**9]), ("a", "b"), values))
    write_log(log, tmp_path / "log")
    assert read_log(tmp_path / "log").joint_states.position.tobytes() == values.tobytes()


def test_existing_folder_is_refused(tmp_path, make_log):
    with pytest.raises(InputError, match="exists already"):
        write_log(make_log(), tmp_path)
