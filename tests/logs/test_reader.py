from __future__ import annotations

import dataclasses
import shutil

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from flexros.config.topics import load_topics
from flexros.errors import InputError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.schemas import message_schema
from flexros.logs.reader import read_log
from flexros.logs.write_log import write_log
from flexros.logs.writer import LogWriter

pytestmark = pytest.mark.slow

JOINT_STATE = "sensor_msgs/msg/JointState"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"
TEMPLATE = JointStateTemplate(["a"], position=True)


def foreign(path, topics, *, schema_text=None, encoding="cdr", **options):
    """Write messages with the reference implementation: topic -> (type, [payloads])."""
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        for name, (type_name, payloads) in topics.items():
            text = message_schema(type_name).text if schema_text is None else schema_text
            channel = writer.register_channel(
                name, encoding, writer.register_schema(type_name, "ros2msg", text.encode())
            )
            for k, payload in enumerate(payloads):
                writer.add_message(channel, 7_000 + k, payload, 7_000 + k)
        writer.finish()
    return path


def states(*stamps):
    return JOINT_STATE, [TEMPLATE.fill(stamp, [stamp / 2]) for stamp in stamps]


def test_single_file_is_read_like_its_folder(tmp_path, make_log, assert_same_log):
    write_log(make_log(), tmp_path / "log")
    assert_same_log(read_log(tmp_path / "log"), read_log(tmp_path / "log" / "log_0.mcap"))


def test_topics_are_left_out(tmp_path, make_log):
    log = make_log()
    write_log(log, tmp_path / "log")
    read = read_log(tmp_path / "log", leave_out=("tool_reference",))
    assert read.tool_reference is None
    np.testing.assert_array_equal(read.joint_states.position, log.joint_states.position)


def test_path_may_be_text(tmp_path, make_log):
    write_log(make_log(), tmp_path / "log")
    assert len(read_log(str(tmp_path / "log")).joint_states.stamp) == 50


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("use_chunking", [True, False])
def test_every_kind_of_file(tmp_path, compression, use_chunking):
    path = foreign(
        tmp_path / "x.mcap", {"/joint_states": states(1, 2, 3)}, compression=compression, use_chunking=use_chunking
    )
    log = read_log(path)
    assert log.joint_states.stamp.tolist() == [1, 2, 3]
    assert log.joint_states.position[:, 0].tolist() == [0.5, 1.0, 1.5]
    assert log.warnings == ()


def test_other_topics_are_counted(tmp_path):
    header = message_schema("std_msgs/msg/Header")
    path = foreign(
        tmp_path / "x.mcap",
        {"/camera/info": (header.type, [b"junk"] * 3), "/joint_states": states(1), "/empty": (header.type, [])},
    )
    log = read_log(path)
    assert dict(log.other_topics) == {"/camera/info": 3, "/empty": 0}
    assert log.warnings == ()


def test_topic_without_leading_slash(tmp_path):
    assert read_log(foreign(tmp_path / "x.mcap", {"joint_states": states(1)})).joint_states.stamp.tolist() == [1]


def test_only_namespace_is_found(tmp_path):
    path = foreign(tmp_path / "x.mcap", {"/lab/robot1/joint_states": states(1, 2), "/joint_commands": states(1)})
    log = read_log(path)
    assert log.joint_states.stamp.tolist() == [1, 2]
    assert log.joint_commands is None
    assert dict(log.other_topics) == {"/joint_commands": 1}


def test_several_namespaces_must_be_chosen_from(tmp_path):
    path = foreign(
        tmp_path / "x.mcap", {"/r1/joint_states": states(1), "/r2/joint_states": states(2), "/joint_states": states(3)}
    )
    with pytest.raises(InputError, match="in the namespaces '', 'r1', 'r2'; choose one with the argument namespace"):
        read_log(path)
    chosen = {namespace: read_log(path, namespace).joint_states.stamp.tolist() for namespace in ("r1", "/r2/", "")}
    assert chosen == {"r1": [1], "/r2/": [2], "": [3]}


def test_wrong_namespace_lists_what_is_there(tmp_path):
    path = foreign(tmp_path / "x.mcap", {"/r1/joint_states": states(1)})
    with pytest.raises(InputError, match=r"no readable messages of /r3/joint_states .* it holds /r1/joint_states"):
        read_log(path, "r3")


def test_missing_required_topic_lists_what_is_there(tmp_path):
    path = foreign(tmp_path / "x.mcap", {"/joint_commands": states(1, 2)})
    with pytest.raises(InputError) as caught:
        read_log(path)
    assert "no readable messages of /joint_states (sensor_msgs/msg/JointState)" in str(caught.value)
    assert "it holds /joint_commands (sensor_msgs/msg/JointState, 2)" in str(caught.value)
    assert "record that topic, or map your own topics to it" in str(caught.value)


def test_required_topic_without_messages(tmp_path):
    with LogWriter(tmp_path / "log", [load_topics()["joint_states"]], {}):
        pass
    with pytest.raises(InputError, match=r"it holds /joint_states \(.*, 0\)"):
        read_log(tmp_path / "log")


def test_topic_of_another_type_is_named(tmp_path):
    header = "std_msgs/msg/Header"
    path = foreign(tmp_path / "x.mcap", {"/joint_states": states(1), "/tool_pose": (header, [b"junk"])})
    log = read_log(path)
    assert log.tool_pose is None
    assert log.warnings == (
        "/tool_pose has the type std_msgs/msg/Header, allowed is geometry_msgs/msg/PoseStamped; it was left out",
    )


def test_topic_in_another_encoding_is_named(tmp_path):
    path = foreign(tmp_path / "x.mcap", {"/joint_states": states(1)}, encoding="json")
    with pytest.raises(InputError, match="/joint_states is encoded as 'json', allowed is cdr; it was left out"):
        read_log(path)


def test_file_without_definitions(tmp_path):
    log = read_log(foreign(tmp_path / "x.mcap", {"/joint_states": states(1, 2)}, schema_text=""))
    assert log.joint_states.stamp.tolist() == [1, 2]
    assert "sensor_msgs/msg/JointState has no definition in the file, that of ROS 2 Jazzy is used" in log.warnings[0]


def test_definition_of_the_file_is_used(tmp_path):
    """Velocity and effort stand in another order than in the common definition."""
    text = message_schema(JOINT_STATE).text
    swapped = text.replace("velocity", "x").replace("effort", "velocity").replace("[] x", "[] effort")
    payloads = [JointStateTemplate(["a"], effort=True).fill(k + 1, effort=[k]) for k in range(3)]
    log = read_log(foreign(tmp_path / "x.mcap", {"/joint_states": (JOINT_STATE, payloads)}, schema_text=swapped))
    assert log.joint_states.velocity[:, 0].tolist() == [0.0, 1.0, 2.0]
    assert log.joint_states.effort is None


def test_split_log(tmp_path, make_log, assert_same_log):
    log = make_log(400)
    folder = tmp_path / "split"
    folder.mkdir()
    for number, rows in enumerate((slice(200, 400), slice(0, 200))):
        parts = {}
        for name in ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference"):
            series = getattr(log, name)
            arrays = {k: v[rows] for k, v in vars(series).items() if isinstance(v, np.ndarray)}
            parts[name] = dataclasses.replace(series, **arrays)
        write_log(dataclasses.replace(log, **parts), tmp_path / f"part{number}")
        shutil.copy(tmp_path / f"part{number}" / f"part{number}_0.mcap", folder / f"split_{number}.mcap")
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  storage_identifier: mcap\n"
        "  relative_file_paths: [split_0.mcap, split_1.mcap]\n"
    )
    again = read_log(folder)
    assert_same_log(log, again)
    assert again.warnings == tuple(
        f"/{name}: messages are not in the order of their stamps, they were sorted"
        for name in ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference")
    )


def test_times_of_receipt_come_from_the_log_times(tmp_path):
    log = read_log(foreign(tmp_path / "x.mcap", {"/joint_states": states(1, 2), "/joint_commands": states(7_000)}))
    assert log.joint_states.received.tolist() == [7_000, 7_001]
    assert log.joint_commands.received is None


def with_diagnostics(path, store, messages, prefix="", **options):
    payloads = [bytes(store.serialize_cdr(message, DIAGNOSTIC_ARRAY)) for message in messages]
    topics = {f"{prefix}/joint_states": states(1), "/diagnostics": (DIAGNOSTIC_ARRAY, payloads)}
    return read_log(foreign(path, topics, **options))


def test_the_plant_has_the_last_word_on_each_figure(tmp_path, store, diagnostics):
    running = diagnostics(("/plant", "running", {"late": "3", "resends": "1"}), ("/camera", "", {"late": "9"}))
    log = with_diagnostics(tmp_path / "x.mcap", store, [running, diagnostics(("plant", "done", {"late": "5"}))])
    assert log.plant_figures == {"late": 5.0, "resends": 1.0}
    assert log.other_topics == {"/diagnostics": 2}
    assert log.warnings == ()


def test_figures_are_those_of_the_plant_in_the_namespace(tmp_path, store, diagnostics):
    message = diagnostics(("/r1/plant", "", {"late": "1"}), ("/plant", "", {"late": "2"}))
    assert with_diagnostics(tmp_path / "x.mcap", store, [message], "/r1").plant_figures == {"late": 1.0}
    assert with_diagnostics(tmp_path / "y.mcap", store, [message]).plant_figures == {"late": 2.0}
    assert with_diagnostics(tmp_path / "z.mcap", store, [message], "/r2").plant_figures == {}


def test_diagnostics_that_cannot_be_read_leave_the_log_readable(tmp_path):
    junk = {"/joint_states": states(1), "/diagnostics": (DIAGNOSTIC_ARRAY, [b"junk", b"junk"])}
    log = read_log(foreign(tmp_path / "x.mcap", junk))
    assert log.plant_figures == {}
    (warning,) = log.warnings
    assert warning.startswith(
        "/diagnostics: 2 messages were left out, so the pace of the loop may be unknown (the first: a message begins"
    )


def test_diagnostics_of_another_type_are_left_out(tmp_path):
    junk = {"/joint_states": states(1), "/diagnostics": ("std_msgs/msg/Header", [b"junk"])}
    (warning,) = read_log(foreign(tmp_path / "x.mcap", junk)).warnings
    assert "(the first: it is a std_msgs/msg/Header in 'cdr')" in warning


def test_diagnostics_of_another_definition_are_left_out(tmp_path):
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        for name, kind, text, payload in (
            ("/joint_states", JOINT_STATE, message_schema(JOINT_STATE).text, states(1)[1][0]),
            ("/diagnostics", DIAGNOSTIC_ARRAY, "string all", b"junk"),
        ):
            channel = writer.register_channel(name, "cdr", writer.register_schema(kind, "ros2msg", text.encode()))
            writer.add_message(channel, 1, payload, 1)
        writer.finish()
    (warning,) = read_log(path).warnings
    assert "(the first: its definition of diagnostic_msgs/msg/DiagnosticArray is not that of ROS 2 Jazzy)" in warning


def test_truncated_log_is_read_up_to_its_last_complete_chunk(tmp_path, make_log):
    log = make_log(4000)
    write_log(log, tmp_path / "log")
    path = tmp_path / "log" / "log_0.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    again = read_log(tmp_path / "log")
    n = len(again.joint_states.stamp)
    assert 1000 <= n < 4000
    assert n % 1000 == 0, "chunks of 5000 messages"
    np.testing.assert_array_equal(again.tool_pose.position, log.tool_pose.position[:n])
    assert any("is truncated at byte" in warning for warning in again.warnings)


def test_damaged_chunk_is_named_and_the_rest_read(tmp_path, make_log):
    write_log(make_log(4000), tmp_path / "log")
    path = tmp_path / "log" / "log_0.mcap"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    log = read_log(tmp_path / "log")
    assert len(log.joint_states.stamp) == 3000
    assert "is damaged and was left out" in log.warnings[0]


def test_unknown_channel_is_counted(tmp_path):
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", message_schema(JOINT_STATE).text.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        writer.add_message(channel, 1, states(1)[1][0], 1)
        writer.add_message(77, 2, states(2)[1][0], 2)
        writer.finish()
    log = read_log(path)
    assert log.joint_states.stamp.tolist() == [1]
    assert any("1 messages name a channel that is not defined" in warning for warning in log.warnings)


def test_random_damage_gives_a_log_or_a_sentence(tmp_path):
    """Uncompressed and without checksums, so that the damage reaches records, definitions and messages."""
    options = {"compression": CompressionType.NONE, "enable_crcs": False}
    path = foreign(tmp_path / "x.mcap", {"/joint_states": states(*range(1, 40))}, **options)
    content = path.read_bytes()
    rng = np.random.default_rng(3)
    outcomes = []
    for _ in range(150):
        damaged = bytearray(content)
        for at in rng.integers(8, len(content) * 2 // 3, 3):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged)
        outcomes.append(outcome(path))
    assert outcomes.count("read") > 10
    assert all(text == "read" or str(path) in text for text in outcomes)


def outcome(path):
    try:
        read_log(path)
    except InputError as error:
        return str(error)
    return "read"
