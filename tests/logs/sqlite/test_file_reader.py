"""Bags in SQLite storage are read like those in MCAP."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from flexros.errors import InputError
from flexros.logs.bag.reader import bag_file_reader
from flexros.logs.foreign.signal_source import open_source
from flexros.logs.messages.bulk_decode import payloads_of
from flexros.logs.reader import read_log
from flexros.logs.sqlite.file_reader import SqliteFileReader

STORE = get_typestore(Stores.ROS2_HUMBLE)
JOINT_STATE = "sensor_msgs/msg/JointState"
N = 500


def write_bag(folder, storage, version=8):
    header, time = STORE.types["std_msgs/msg/Header"], STORE.types["builtin_interfaces/msg/Time"]
    with Writer(folder, version=version, storage_plugin=storage) as writer:
        connection = writer.add_connection("/joint_states", JOINT_STATE, typestore=STORE)
        text = writer.add_connection("/note", "std_msgs/msg/String", typestore=STORE)
        for k in range(N):
            stamp = 10**18 + 4_000_000 * k
            value = np.array([0.1 * k, -0.2 * k])
            message = STORE.types[JOINT_STATE](
                header(time(stamp // 10**9, stamp % 10**9), ""), ["a", "b"], *[value] * 3
            )
            writer.write(connection, stamp + 1000, STORE.serialize_cdr(message, JOINT_STATE))
        note = STORE.types["std_msgs/msg/String"]("hello")
        writer.write(text, stamp, STORE.serialize_cdr(note, "std_msgs/msg/String"))
    return folder


@pytest.fixture(name="bags", scope="module")
def bags_fixture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    plugins = {"db3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}
    return {name: write_bag(folder / name, plugin) for name, plugin in plugins.items()}


def content(folder):
    """Topic, type, time and payload of every message."""
    found = []
    for file in sorted(folder.glob("*.mcap")) + sorted(folder.glob("*.db3")):
        reader = bag_file_reader(file)
        for block in reader.blocks():
            channels = block.headers["channel"].tolist()
            payloads = payloads_of(block, np.arange(len(channels)))
            for number, time, payload in zip(channels, block.headers["log_time"].tolist(), payloads, strict=True):
                channel = reader.channels[number]
                found.append((channel.topic, reader.schemas[channel.schema_id].name, time, bytes(payload)))
        assert reader.warnings == []
    return found


def test_same_messages_as_in_mcap(bags):
    assert len(content(bags["db3"])) == N + 1
    assert content(bags["db3"]) == content(bags["mcap"])


def test_log_and_signals_are_those_of_mcap(bags):
    logs = {name: read_log(folder) for name, folder in bags.items()}
    np.testing.assert_array_equal(logs["db3"].joint_states.position, logs["mcap"].joint_states.position)
    np.testing.assert_array_equal(logs["db3"].joint_states.stamp, logs["mcap"].joint_states.stamp)
    names = {name: open_source(folder).names for name, folder in bags.items()}
    assert names["db3"] == names["mcap"]
    assert "/joint_states.position[b]" in names["db3"]


def test_definitions_of_the_file_count_where_it_has_them(bags, tmp_path):
    path = tmp_path / "own.db3"
    path.write_bytes(next(bags["db3"].glob("*.db3")).read_bytes())
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DROP TABLE IF EXISTS message_definitions")
        connection.execute(
            "CREATE TABLE message_definitions (topic_type TEXT, encoding TEXT, encoded_message_definition TEXT)"
        )
        row = ("std_msgs/msg/String", "ros2msg", "string data  # ours")
        connection.execute("INSERT INTO message_definitions VALUES (?, ?, ?)", row)
        connection.commit()
    reader = SqliteFileReader(path)
    assert sum(len(block.headers) for block in reader.blocks()) == N + 1
    texts = {schema.name: schema.data.decode() for schema in reader.schemas.values()}
    assert texts["std_msgs/msg/String"] == "string data  # ours"
    assert "float64[] effort" in texts[JOINT_STATE]


def test_unknown_type_has_no_definition(bags, tmp_path):
    path = tmp_path / "other.db3"
    path.write_bytes(next(bags["db3"].glob("*.db3")).read_bytes())
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE topics SET type = 'my_msgs/msg/Mine' WHERE name = '/note'")
        connection.commit()
    assert "/note.data" not in open_source(path).names
    assert "/joint_states.effort[a]" in open_source(path).names


@pytest.mark.parametrize("junk", [b"", b"SQLite format 3\x00 and then nothing", b"words"])
def test_file_that_is_no_bag_is_refused(tmp_path, junk):
    (tmp_path / "x.db3").write_bytes(junk)
    with pytest.raises(InputError, match=r"x.db3 cannot be read as a bag in SQLite storage \(.*\); give a whole copy"):
        list(SqliteFileReader(tmp_path / "x.db3").blocks())


def test_damaged_file_is_read_up_to_the_damage(bags, tmp_path):
    path, whole = tmp_path / "cut.db3", next(bags["db3"].glob("*.db3")).read_bytes()
    path.write_bytes(whole[: len(whole) // 2] + bytes(len(whole) - len(whole) // 2))
    reader = SqliteFileReader(path)
    n = sum(len(block.headers) for block in reader.blocks())
    assert 0 < n < N
    assert "cut.db3 is damaged" in reader.warnings[0]


def test_messages_of_no_topic_are_left_out(bags, tmp_path):
    path = tmp_path / "lost.db3"
    path.write_bytes(next(bags["db3"].glob("*.db3")).read_bytes())
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DELETE FROM topics WHERE name = '/note'")
        connection.commit()
    reader = SqliteFileReader(path)
    assert sum(len(block.headers) for block in reader.blocks()) == N
    assert reader.warnings == [f"{path}: 1 messages belong to no topic, they were left out"]
