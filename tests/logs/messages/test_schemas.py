from __future__ import annotations

import pytest

from flexros.config.topics import load_topics
from flexros.errors import InputError
from flexros.logs.messages.schemas import DEFINITIONS, jazzy_schema, jazzy_types, message_schema, signature

JOINT_STATE = "sensor_msgs/msg/JointState"
HEADER_SECTION = f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
TIME_SECTION = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"


@pytest.mark.parametrize("type_name", sorted({topic.type for topic in load_topics().values()}))
def test_every_topic_has_a_schema(type_name):
    schema = message_schema(type_name)
    assert schema.type_hash.startswith("RIHS01_")
    assert signature(type_name, schema.text)


def test_unknown_type_is_named():
    with pytest.raises(
        InputError, match="unknown message type 'my_msgs/msg/Torque': allowed are the common interfaces"
    ):
        message_schema("my_msgs/msg/Torque")


def test_signature_ignores_comments_constants_defaults_and_blanks():
    text = (
        "# comment\nuint8 LEVEL=3\nHeader   header # the header\n\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[]   effort\n" + HEADER_SECTION + TIME_SECTION
    )
    assert signature(JOINT_STATE, text) == signature(JOINT_STATE, message_schema(JOINT_STATE).text)


@pytest.mark.parametrize(
    "change", [("effort", "torque"), ("float64[] effort", "float32[] effort"), ("[] name", " name")]
)
def test_signature_tells_definitions_apart(change):
    text = message_schema(JOINT_STATE).text
    assert change[0] in text
    assert signature(JOINT_STATE, text.replace(*change)) != signature(JOINT_STATE, text)


def test_lacking_nested_type_is_named():
    with pytest.raises(InputError, match="lacks the nested type std_msgs/Header"):
        signature(JOINT_STATE, "std_msgs/Header header\n")


def test_endless_nesting_is_refused():
    with pytest.raises(InputError, match="lacks the nested type a/A"):
        signature("a/msg/A", "a/A inner\n")


def test_line_that_is_no_field_is_named():
    with pytest.raises(InputError, match=r"the line '\$\$ what'"):
        signature("a/msg/A", "$$ what\n")


def write_share(folder, type_hash="RIHS01_abc"):
    for package, name, text in (
        ("my_msgs", "Torque", "# motor torque\nstd_msgs/Header header\nfloat64 value\n"),
        ("std_msgs", "Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
        ("builtin_interfaces", "Time", "int32 sec\nuint32 nanosec\n"),
    ):
        (folder / package / "msg").mkdir(parents=True)
        (folder / package / "msg" / f"{name}.msg").write_text(text)
    (folder / "my_msgs" / "msg" / "Torque.json").write_text(
        f'{{"type_hashes": [{{"type_name": "my_msgs/msg/Torque", "hash_string": "{type_hash}"}}]}}'
    )


def test_definition_from_an_installation(tmp_path):
    write_share(tmp_path)
    schema = message_schema("my_msgs/msg/Torque", [tmp_path])
    assert schema.type_hash == "RIHS01_abc"
    assert signature("my_msgs/msg/Torque", schema.text)[1] == ("value", "float64", "")
    assert schema.text.count("=" * 80 + "\nMSG: ") == 2


def test_damaged_installation_is_named(tmp_path):
    write_share(tmp_path)
    (tmp_path / "std_msgs" / "msg" / "Header.msg").unlink()
    with pytest.raises(InputError, match=r"the definition of my_msgs/msg/Torque below .* is damaged"):
        message_schema("my_msgs/msg/Torque", [tmp_path])


def test_real_installation_agrees_with_the_fallback():
    ament = pytest.importorskip("sensor_msgs", reason="ROS message packages are not installed")
    from pathlib import Path

    share = next((p / "share" for p in Path(ament.__file__).parents if (p / "share" / "sensor_msgs").is_dir()), None)
    if share is None:
        pytest.skip("the message packages have no share folder")
    for type_name in (JOINT_STATE, "geometry_msgs/msg/PoseStamped", "diagnostic_msgs/msg/DiagnosticArray"):
        installed, fallback = message_schema(type_name, [share]), message_schema(type_name)
        assert installed.type_hash == fallback.type_hash
        assert signature(type_name, installed.text) == signature(type_name, fallback.text)
        assert "#" in installed.text, "the text of the installation has its comments"


@pytest.mark.parametrize("type_name", sorted({topic.type for topic in load_topics().values()}))
def test_kept_definitions_are_those_of_jazzy(type_name):
    assert type_name in DEFINITIONS.read_text()
    assert message_schema(type_name) == jazzy_schema(type_name)


def test_types_are_those_of_jazzy():
    assert "rosgraph_msgs/msg/Clock" in jazzy_types().types
