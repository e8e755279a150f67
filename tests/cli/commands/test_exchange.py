"""Commands that exchange robots with other simulators."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.effects.patching.patched_robot import load_patched
from tests.robot.exchange.mjcf.arm_mjcf import ARM

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


@pytest.fixture
def base(tmp_path: Path) -> Path:
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    return file


def test_import_writes_robot_and_patch(flexros: Flexros, base: Path, tmp_path: Path) -> None:
    out = tmp_path / "arm.yaml"
    ended = flexros("import-mjcf", str(base), "--out", str(out), "--json")
    assert ended.code == 0
    content = json.loads(ended.out)
    assert content["patch"] == str(tmp_path / "arm_patch.yaml")
    effect = content["effects"][0]
    assert (effect["effect"], effect["location"], effect["value"]) == ("coulomb_friction", "motor_1", 2.0)
    assert flexros("robot", content["patch"]).code == 0
    again = flexros("import-mjcf", str(base), "--out", str(out))
    assert (again.code, "exists already" in again.err) == (2, True)


def test_what_comes_next_is_the_patch_with_the_friction(flexros: Flexros, base: Path, tmp_path: Path) -> None:
    out, plain = tmp_path / "arm.yaml", tmp_path / "plain.yaml"
    ended = flexros("import-mjcf", str(base), "--out", str(out))
    assert f"--model {tmp_path / 'arm_patch.yaml'} --out log" in ended.err
    assert f"{out} is the robot without" in ended.err
    base.write_text(ARM.replace("frictionloss", "user"))
    ended = flexros("import-mjcf", str(base), "--out", str(plain))
    assert f"--model {plain} --out log" in ended.err


def test_import_names_the_option_of_the_end_body(flexros: Flexros, base: Path, tmp_path: Path) -> None:
    ended = flexros("import-mjcf", str(base), "--out", str(tmp_path / "a.yaml"), "--end", "hnd")
    assert ended.code == 2
    assert "--end" in ended.err
    assert not (tmp_path / "a.yaml").exists()


def test_round_trip_of_an_import_changes_nothing(flexros: Flexros, base: Path, tmp_path: Path) -> None:
    out, written = tmp_path / "arm.yaml", tmp_path / "again.xml"
    assert flexros("import-mjcf", str(base), "--out", str(out)).code == 0
    patch = str(tmp_path / "arm_patch.yaml")
    ended = flexros("export", patch, "--to", "mjcf", "--base", str(base), "--out", str(written), "--json")
    assert ended.code == 0
    assert json.loads(ended.out)["written"] == []
    assert written.read_text() == ARM


@pytest.mark.parametrize("to", ["mjcf", "urdf", "sdf", "json"])
def test_export_lists_what_was_written(flexros: Flexros, tmp_path: Path, to: str) -> None:
    out = tmp_path / "elbow.out"
    ended = flexros("export", "elbow", "--to", to, "--out", str(out))
    assert ended.code == 0
    assert "viscous friction" in ended.out
    assert out.stat().st_size > 100


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--to", "usd"), "--to"),
        (("--to", "mjcf", "--joint", "motor_1"), "--joint"),
        (("--to", "json", "--base", "x.json"), "--base"),
        (("--to", "mjcf", "--base", "missing.xml"), "missing.xml"),
    ],
)
def test_bad_options_write_nothing(flexros: Flexros, tmp_path: Path, options: tuple[str, ...], named: str) -> None:
    out = tmp_path / "out.xml"
    ended = flexros("export", "elbow", *options, "--out", str(out))
    assert (ended.code, named in ended.err, out.exists()) == (2, True, False)


def test_base_is_never_overwritten(flexros: Flexros, base: Path) -> None:
    ended = flexros("export", "elbow", "--to", "mjcf", "--base", str(base), "--out", str(base))
    assert (ended.code, base.read_text()) == (2, ARM)


URDF = (
    "<robot name='a'><link name='b'/><link name='c'><inertial><mass value='1'/>"
    "<inertia ixx='1' iyy='1' izz='1'/></inertial></link><joint name='j' type='revolute'><parent link='b'/>"
    "<child link='c'/><axis xyz='0 0 -1'/><dynamics damping='0.1' friction='0.3'/></joint></robot>"
)


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    file = tmp_path / "a.urdf"
    file.write_text(URDF)
    return file


def test_import_urdf_writes_a_patch_with_dry_friction(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    assert flexros("import-urdf", str(urdf), "--out", str(tmp_path / "a.yaml")).code == 0
    (law,) = load_patched(tmp_path / "a_patch.yaml").model.laws
    assert law.parameters["coulomb_friction@motor_1.level"] == 0.3


def test_import_urdf_prints_joints_and_effects_for_programs(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.yaml"
    ended = flexros("import-urdf", str(urdf), "--out", str(out), "--json")
    assert ended.code == 0
    content = json.loads(ended.out)
    assert (content["robot"], content["patch"]) == (str(out), str(tmp_path / "a_patch.yaml"))
    assert content["joints"] == [{"coordinate": "motor_1", "joint": "j", "sign": -1, "reference": 0.0}]
    (effect,) = content["effects"]
    assert (effect["effect"], effect["location"], effect["value"]) == ("coulomb_friction", "motor_1", 0.3)


def test_import_urdf_prints_the_signs_of_its_joints(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    ended = flexros("import-urdf", str(urdf), "--out", str(tmp_path / "a.yaml"))
    rows = [line.replace("│", "|").split("|")[1:-1] for line in ended.out.splitlines() if "motor_1" in line]
    assert ["motor_1", "j", "-1", "0"] in [[cell.strip() for cell in row] for row in rows]


def test_import_urdf_says_what_it_assumes(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    urdf.write_text(URDF.replace("<link name='b'/>", ""))
    ended = flexros("import-urdf", str(urdf), "--out", str(tmp_path / "a.yaml"))
    assert (ended.code, "the base link b, which the URDF does not declare" in " ".join(ended.out.split())) == (0, True)


def test_import_urdf_without_dry_friction_writes_no_patch(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    urdf.write_text(URDF.replace("friction='0.3'", ""))
    ended = flexros("import-urdf", str(urdf), "--out", str(tmp_path / "a.yaml"), "--json")
    assert (ended.code, json.loads(ended.out)["patch"]) == (0, None)
    assert not (tmp_path / "a_patch.yaml").exists()


@pytest.mark.parametrize(
    ("out", "patch", "told"),
    [
        ("ur5e", "p.yaml", "does not end in .yaml"),
        ("a.yaml", "a.yaml", "is the robot file itself"),
        ("a.yaml", "no/p.yaml", "does not exist"),
    ],
)
def test_import_urdf_writes_nothing_that_could_not_be_used(
    flexros: Flexros, urdf: Path, tmp_path: Path, out: str, patch: str, told: str
) -> None:
    ended = flexros("import-urdf", str(urdf), "--out", str(tmp_path / out), "--patch", str(tmp_path / patch))
    assert (ended.code, told in ended.err) == (2, True)
    assert [file.name for file in tmp_path.iterdir()] == ["a.urdf"]


def test_import_urdf_refuses_to_overwrite(flexros: Flexros, urdf: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.yaml"
    assert flexros("import-urdf", str(urdf), "--out", str(out)).code == 0
    assert flexros("robot", str(out)).code == 0
    ended = flexros("import-urdf", str(urdf), "--out", str(out))
    assert (ended.code, "exists already" in ended.err) == (2, True)
