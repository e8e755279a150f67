"""Import of foreign logs from the command line."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from flexros.logs.reader import read_log

MAPPING = """
time: {rate: 1000}
columns:
  - {column: q, quantity: position, unit: deg}
  - {column: u, quantity: torque_command, unit: Nm}
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    (tmp_path / "mine.yaml").write_text(MAPPING)
    (tmp_path / "log.csv").write_text("q,u\n" + "".join(f"{k},{2 * k}\n" for k in range(100)))
    return str(tmp_path / "mine.yaml"), str(tmp_path / "log.csv")


def test_import_writes_a_log(flexros, files, tmp_path: Path) -> None:
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"), "--json")
    assert ended.code == 0, ended.err
    printed = json.loads(ended.out)
    assert [row["topic"] for row in printed["topics"]] == ["joint_states", "joint_commands"]
    assert printed["topics"][0]["rate_hz"] == pytest.approx(1000)
    assert read_log(tmp_path / "bag").joint_commands.effort[-1, 0] == 198


def test_table_says_what_was_imported(flexros, files, tmp_path: Path) -> None:
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert ended.code == 0, ended.err
    assert "joint_commands" in ended.out
    assert "Joints: motor_1" in ended.out
    assert "--tolerance torque=0.005" in ended.out


def test_a_log_that_torques_drive_is_compared_with_a_model_next(flexros, files, tmp_path: Path) -> None:
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert f"Next: flexros gap {tmp_path / 'bag'} --model ROBOT" in ended.err


def test_analyse_takes_the_log(flexros, files, tmp_path: Path) -> None:
    flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert flexros("analyze", str(tmp_path / "bag"), "--json").code == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("emp", None), "unknown mapping 'emp': did you mean 'emps'? allowed are emps"),
        (("emps", None), "unknown column of mapping emps 'qm'"),
        ((None, "nowhere.csv"), "there is no file nowhere.csv"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(flexros, files, tmp_path: Path, change, message: str) -> None:
    arguments = [given or usual for given, usual in zip(change, files, strict=True)]
    ended = flexros("import", *arguments, "--out", str(tmp_path / "bag"))
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.told) == 1
    assert not (tmp_path / "bag").exists()


def test_existing_folder_is_kept(flexros, files, tmp_path: Path) -> None:
    assert flexros("import", *files, "--out", str(tmp_path / "bag")).code == 0
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert ended.code == 2
    assert "exists" in ended.err


STAMP = 1_790_000_000 * 10**9


def test_a_table_of_a_single_row_is_refused(flexros, tmp_path: Path) -> None:
    table = tmp_path / "one.csv"
    table.write_text("time,q1,tau1\n0,1,2\n")
    ended = flexros("import", str(table), "--model", "emps", "--out", str(tmp_path / "log"))
    assert (ended.code, "fewer than 2 positions" in ended.err) == (2, True)


@pytest.fixture
def bag(tmp_path: Path) -> str:
    """Write a bag of a robot with one joint and a gripper, without a URDF."""
    types = get_typestore(Stores.ROS2_JAZZY)
    State = types.types["sensor_msgs/msg/JointState"]
    with Writer(tmp_path / "drive", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/joint_states", State.__msgtype__, typestore=types)
        for k in range(400):
            stamp = STAMP + k * 2_000_000
            header = types.types["std_msgs/msg/Header"](
                types.types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), ""
            )
            angle, rate = np.sin(0.01 * k), 5 * np.cos(0.01 * k)
            values = (np.array([0.5, value]) for value in (angle, rate, 3 * angle))
            writer.write(
                topic, stamp, types.serialize_cdr(State(header, ["finger", "motor_1"], *values), State.__msgtype__)
            )
    return str(tmp_path / "drive")


def test_mapping_of_a_bag_is_proposed(flexros, bag, tmp_path: Path) -> None:
    ended = flexros("import", bag, "--model", "two_mass", "--out", str(tmp_path / "log"), "--json")
    assert ended.code == 0, ended.err
    printed = json.loads(ended.out)
    assert printed["mapping"] == str(tmp_path / "log_mapping.yaml")
    assert {each["about"] for each in printed["assumptions"]} >= {"topics", "rate", "joints", "position", "effort"}
    assert any("finger" in each["taken"] for each in printed["assumptions"])
    assert read_log(tmp_path / "log").joint_states.names == ("motor_1",)


def test_proposed_mapping_imports_the_same_log(flexros, bag, tmp_path: Path) -> None:
    mapping, first, second = (str(tmp_path / name) for name in ("mine.yaml", "first", "second"))
    assert flexros("import", bag, "--model", "two_mass", "--out", first, "--mapping", mapping).code == 0
    assert flexros("import", mapping, bag, "--out", second).code == 0
    states = [read_log(Path(folder)).joint_states for folder in (first, second)]
    assert np.array_equal(states[0].effort, states[1].effort)


def test_without_a_folder_the_mapping_alone_is_written(flexros, bag, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert flexros("import", bag, "--model", "two_mass").code == 0
    assert (tmp_path / "drive_mapping.yaml").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["emps"], "emps is given without files"),
        (["log.csv"], "no column whose name says that it is a time"),
        (["other.csv"], "there is no file other.csv"),
        (["log.csv", "log.csv", "--out", "log"], "log.csv is a log; give one log alone"),
        (["emps", "log.csv"], "--out: no folder"),
        (["emps", "log.csv", "--out", "log", "--model", "two_mass"], "--model: two_mass"),
    ],
)
def test_what_does_not_go_together(flexros, files, tmp_path: Path, monkeypatch, arguments, message: str) -> None:
    monkeypatch.chdir(tmp_path)
    ended = flexros("import", *arguments)
    assert ended.code == 2
    assert message in ended.err
    assert not (tmp_path / "log").exists()


def test_a_log_that_was_removed_is_imported_again(flexros, bag, tmp_path: Path) -> None:
    """Its mapping, which is still there, says the same."""
    log = tmp_path / "log"
    for _ in range(2):
        ended = flexros("import", bag, "--model", "two_mass", "--out", str(log))
        assert ended.code == 0, ended.err
        shutil.rmtree(log)


def test_existing_mapping_is_kept(flexros, bag, tmp_path: Path) -> None:
    (tmp_path / "log_mapping.yaml").write_text("mine")
    ended = flexros("import", bag, "--model", "two_mass", "--out", str(tmp_path / "log"))
    assert ended.code == 2
    assert f"to import the log by it: flexros import {tmp_path / 'log_mapping.yaml'} {bag} --out LOG" in ended.err
    assert (tmp_path / "log_mapping.yaml").read_text() == "mine"
    assert not (tmp_path / "log").exists()


def test_what_is_assumed_of_a_urdf_is_listed(flexros, tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(
        "<robot name='a'><link name='c'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
        "<joint name='j' type='revolute'><parent link='world'/><child link='c'/><axis xyz='0 0 1'/></joint></robot>"
    )
    (tmp_path / "log.csv").write_text("time,q1\n" + "".join(f"{0.01 * k},{np.sin(0.01 * k)}\n" for k in range(100)))
    ended = flexros(
        "import",
        str(tmp_path / "log.csv"),
        "--model",
        str(tmp_path / "a.urdf"),
        "--out",
        str(tmp_path / "log"),
        "--json",
    )
    assert ended.code == 0, ended.err
    first = json.loads(ended.out)["assumptions"][0]
    assert (first["about"], "base link world" in first["taken"]) == ("robot", True)


def test_a_log_that_nothing_drives_is_to_be_completed(flexros, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,q1\n" + "".join(f"{0.01 * k},{np.sin(0.01 * k)}\n" for k in range(100)))
    ended = flexros("import", str(tmp_path / "log.csv"), "--model", "two_mass", "--out", str(tmp_path / "log"))
    assert ended.code == 0, ended.err
    assert "map what drives the robot, torques or commanded positions, by hand" in ended.err + ended.out
