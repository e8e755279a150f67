"""Commands about robots."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from flexros.robot.robot import LIBRARY

pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


def test_robots_lists_all(flexros: Flexros) -> None:
    ended = flexros("robots", "--json")
    assert ended.code == 0
    names = {row["name"] for row in json.loads(ended.out)}
    assert {"two_mass", "elbow", "e12", "four_mass", "four_mass_linear", "six_axis", "emps"} <= names


def test_robot_json_has_the_keys_of_the_contract(flexros: Flexros) -> None:
    ended = flexros("robot", "e12", "--q", "0,0.3,0", "--json")
    assert ended.code == 0
    content = json.loads(ended.out)
    assert content["q"] == [0, 0.3, 0]
    entries = [*content["poles"], *content["transmission_zeros"], *content["zero_dynamics"]]
    for source in ("motor_1", "motor_2"):
        for target in ("motor_1", "motor_2", "x", "z"):
            entries += content["zeros"][source][target]
    assert all(set(entry) == {"re", "im", "hz"} for entry in entries)
    hz = sorted({round(entry["hz"], 5) for entry in content["poles"]})
    assert hz[-3:] == [5.17324, 7.13344, 15.82318]
    assert content["minimum_phase"] is True


def test_robot_table_states_the_verdict(flexros: Flexros) -> None:
    assert "Minimum phase for output 'tool'" in flexros("robot", "e12").out
    assert "NOT minimum phase for output 'tool'" in flexros("robot", "six_axis", "--output", "tool").out


def test_table_of_many_motors_keeps_to_their_own_channels(flexros: Flexros) -> None:
    printed = flexros("robot", "six_axis").out
    assert "zeros motor_3 torque -> motor_3" in printed
    assert "zeros motor_3 torque -> motor_4" not in printed
    assert "Zeros from motors to other locations, 66 channels: --json" in printed
    assert "other locations" not in flexros("robot", "e12").out


def test_robot_at_a_singular_pose(flexros: Flexros) -> None:
    assert "(singular)" in flexros("robot", "e12", "--q", "0,0,0").out


def test_urdf_is_written(flexros: Flexros, tmp_path: Path) -> None:
    file = tmp_path / "e12.urdf"
    ended = flexros("robot", "e12", "--urdf", str(file), "--flexible", "continuous")
    assert ended.code == 0
    assert f"URDF: {file}" in ended.out.replace("\n", "")
    joints = ElementTree.parse(file).findall("joint[@type='continuous']")
    assert [joint.get("name") for joint in joints] == ["motor_1", "body_1.ry", "motor_2", "body_2.ry", "body_3.ry"]


def test_bode_picture_is_written(flexros: Flexros, tmp_path: Path) -> None:
    file = tmp_path / "bode.html"
    assert flexros("robot", "e12", "--bode", str(file)).code == 0
    assert file.stat().st_size > 100_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["robot", "e21"], "unknown robot 'e21': did you mean 'e12'?"),
        (["robot", "e12", "--q", "0,0"], "2 arm coordinates were given, but robot e12 has 3"),
        (["robot", "e12", "--q", "0,nan,0"], "must be finite numbers"),
        (["robot", "e12", "--q", "0;1"], "--q is '0;1', but must be numbers separated by commas"),
        (
            ["robot", "e12", "--urdf", "e12.urdf", "--flexible", "fix"],
            "unknown way to write springs 'fix' in --flexible",
        ),
        (["robot", "e12", "--output", "hand"], "unknown output of robot e12 'hand'"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(flexros: Flexros, arguments: list[str], message: str) -> None:
    ended = flexros(*arguments)
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.told) == 1
    assert ended.out == ""


def test_negative_mass_in_a_robot_file(flexros: Flexros, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text((LIBRARY / "e12.yaml").read_text().replace("mass: 200", "mass: -200"))
    ended = flexros("robot", str(file))
    assert ended.code == 2
    assert f"{file}: key 'bodies[2].mass': is -200 kg, but must be at least 0 kg" in ended.err


def test_broken_yaml(flexros: Flexros, tmp_path: Path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text("name: [e12\n")
    ended = flexros("robot", str(file))
    assert ended.code == 2
    assert "broken YAML" in ended.err


def test_unknown_command(flexros: Flexros) -> None:
    ended = flexros("robt")
    assert ended.code == 2
    assert "No such command" in ended.err


def test_every_command_has_help(flexros: Flexros) -> None:
    from flexros.cli.app import COMMANDS

    for command in COMMANDS:
        ended = flexros(command, "--help")
        assert ended.code == 0
        assert "Usage" in ended.out


def test_a_patch_is_shown_with_its_model_and_says_what_is_no_part_of_it(flexros: Flexros, tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: e12\n"
        "effects:\n"
        "  - {effect: stiffness_error, location: body_1.ry, parameters: {relative: -0.5}}\n"
        "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 10}}\n"
    )
    nominal, softer = flexros("robot", "e12", "--json"), flexros("robot", str(patch), "--json")
    lowest = [min(p["hz"] for p in json.loads(ended.out)["poles"] if p["hz"] > 0.1) for ended in (nominal, softer)]
    assert lowest[1] < 0.95 * lowest[0]
    assert softer.err == (
        f"flexros: {patch} holds coulomb_friction@motor_1, which is no part of a linear model and omitted here\n"
    )


def test_a_patch_for_another_robot_is_refused(flexros: Flexros, tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: e12\neffects: [{effect: backlash, location: motor_3, parameters: {gap: 1e-3}}]\n")
    ended = flexros("robot", str(patch))
    assert ended.code == 2
    assert f"{patch}: unknown location of backlash on robot e12 'motor_3'" in ended.err
