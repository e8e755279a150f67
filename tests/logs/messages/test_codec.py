from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from flexros.config.topics import load_topics
from flexros.errors import InputError
from flexros.logs import reader, write_log
from flexros.logs.messages.codec import codec_of, codecs, series_codecs
from flexros.logs.messages.schemas import jazzy_types
from flexros.logs.time_series import OWN_SERIES, Log, PoseSeries


def test_codecs_are_found_by_their_type():
    assert list(codecs()) == [
        "diagnostic_msgs/msg/DiagnosticArray",
        "geometry_msgs/msg/PoseStamped",
        "sensor_msgs/msg/Imu",
        "sensor_msgs/msg/JointState",
        "trajectory_msgs/msg/JointTrajectory",
    ]


@pytest.mark.parametrize("name", codecs())
def test_every_type_is_one_of_the_common_interfaces(name):
    assert name in jazzy_types().types


@pytest.mark.parametrize("topic", [topic for topic in load_topics().values() if topic.recorded], ids=lambda t: t.name)
def test_every_recorded_topic_has_a_codec(topic):
    assert codec_of(topic.type).type == topic.type


def test_every_series_of_a_log_is_a_recorded_topic_that_becomes_a_series():
    assert all(load_topics()[name].recorded and load_topics()[name].type in series_codecs() for name in OWN_SERIES)
    assert set(OWN_SERIES) < {field.name for field in dataclasses.fields(Log)}


def test_unknown_type_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="sensor_msgs/msg/JointStates.*sensor_msgs/msg/JointState"):
        codec_of("sensor_msgs/msg/JointStates")


def test_further_recorded_topic_is_written_and_read_by_its_row_alone(tmp_path, monkeypatch, make_log):
    """A topic that is not a field of Log needs no more than its row in `topics.yaml`."""
    rows = load_topics()
    further = {**rows, "flange_pose": rows["tool_pose"].model_copy(update={"name": "flange_pose"})}
    monkeypatch.setattr(reader, "load_topics", lambda: further)
    monkeypatch.setattr(write_log, "load_topics", lambda: further)
    stamp = np.array([10**9, 2 * 10**9])
    flange = PoseSeries(stamp, "base", np.array([[1.0, 2.0, 3.0]] * 2), np.array([[0.0, 0.0, 0.6, 0.8]] * 2))
    write_log.write_log(dataclasses.replace(make_log(), other_series={"flange_pose": flange}), tmp_path / "log")
    read = reader.read_log(tmp_path / "log").series("flange_pose")
    np.testing.assert_array_equal(read.position, flange.position)
    np.testing.assert_array_equal(read.orientation, flange.orientation)
