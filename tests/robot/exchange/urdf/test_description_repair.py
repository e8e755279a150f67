"""URDF and SDF with the numbers of a robot."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from flexros.effects.patching.export import Format, export_model
from flexros.effects.patching.patched_robot import PatchedRobot, load_patched
from flexros.errors import InputError
from flexros.robot.exchange.numbers import Export
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

PATCH = """robot: elbow
effects:
  - {effect: coulomb_friction, location: motor_1, parameters: {level: 12}}
  - {effect: viscous_friction, location: motor_2, parameters: {coefficient: 5}}
  - {effect: payload_error, location: tool, parameters: {relative: 0.1}}
  - {effect: delay, location: all, parameters: {time: 0.003}}
  - {effect: backlash, location: motor_1, parameters: {gap: 0.001}}
"""


@pytest.fixture
def patched(tmp_path: Path) -> PatchedRobot:
    file = tmp_path / "patch.yaml"
    file.write_text(PATCH)
    return load_patched(file)


def base_file(tmp_path: Path, to: Format, text: str = "") -> Path:
    base = tmp_path / f"base.{to}"
    base.write_text(text or export_model(load_patched("elbow"), to).text)
    return base


def value(exported: Export, to: Format, joint: str, key: str) -> float:
    root = ElementTree.fromstring(exported.text)
    element = next(each for each in root.iter("joint") if each.get("name") == joint)
    if to == "urdf":
        return float(element.find("dynamics").get(key))  # type: ignore[union-attr,arg-type]
    return float(element.findtext(f"axis/dynamics/{key}"))  # type: ignore[arg-type]


@pytest.mark.parametrize("to", ["urdf", "sdf"])
@pytest.mark.parametrize("with_base", [True, False])
def test_friction_and_payload(to: Format, with_base: bool, patched: PatchedRobot, tmp_path: Path) -> None:
    exported = export_model(patched, to, base_file(tmp_path, to) if with_base else None)
    assert value(exported, to, "motor_1", "friction") == 12
    assert value(exported, to, "motor_2", "damping") == 35
    text = exported.text.replace("49.50000000000001", "49.5")
    assert ('<mass value="49.5"' if to == "urdf" else "<mass>49.5</mass>") in text


@pytest.mark.parametrize("to", ["urdf", "sdf"])
def test_rest_of_the_base_stays_and_the_difference_is_listed(to: Format, patched: PatchedRobot, tmp_path: Path) -> None:
    base = base_file(tmp_path, to)
    base.write_text(base.read_text().replace("?>\n", "?>\n<!-- mine -->\n"))
    exported = export_model(patched, to, base)
    before, after = base.read_text().splitlines(), exported.text.splitlines()
    assert len(before) == len(after)
    assert sum(a != b for a, b in zip(before, after)) <= 6
    rows = {(row.location, row.quantity): (row.before, row.value) for row in exported.written}
    assert rows["motor_2", "viscous friction"] == (30, 35)
    assert rows["motor_1", "dry friction"][1] == 12
    assert rows["body_2", "mass"] == (45, pytest.approx(49.5))


@pytest.mark.parametrize("to", ["urdf", "sdf"])
def test_an_inertia_is_scaled_and_the_mass_kept(to: Format, tmp_path: Path) -> None:
    base, patch = base_file(tmp_path, to), tmp_path / "patch.yaml"
    patch.write_text(
        "robot: elbow\neffects:\n  - {effect: inertia_error, location: body_2, parameters: {relative: -0.6}}\n"
    )
    exported = export_model(load_patched(patch), to, base)
    assert not [row for row in exported.not_held if row.location == "body_2"]
    assert {row.quantity for row in exported.written} == {"inertia"}
    assert all(row.value == pytest.approx(0.4 * (row.before or 0.0)) for row in exported.written)
    if to == "urdf":
        tool = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>"
        weld = "<joint name='weld' type='fixed'><parent link='body_2'/><child link='tool'/></joint>"
        base.write_text(base.read_text().replace("</robot>", f"{weld}<link name='tool'>{tool}</link></robot>"))
        (row,) = [row for row in export_model(load_patched(patch), to, base).not_held if row.location == "body_2"]
        assert (row.name, row.size) == ("inertia", "x 0.4")
        assert "several links as one (body_2, tool)" in row.reason


@pytest.mark.parametrize("to", ["urdf", "sdf"])
def test_gravity_of_a_slanted_base_is_listed(to: Format, tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: elbow\neffects:\n  - {effect: base_tilt, location: base, parameters: {x: 0.1}}\n")
    (row,) = [row for row in export_model(load_patched(patch), to).not_held if row.location == "base"]
    assert (row.name, row.size) == ("gravity", "0, -0.979366, -9.76099 m/s2 in the frame of the base")
    assert f"{to.upper()} is that of the world" in row.reason


@pytest.mark.parametrize("to", ["urdf", "sdf"])
def test_what_has_no_place_is_listed(to: Format, patched: PatchedRobot) -> None:
    rows = {(row.location, row.name): row.size for row in export_model(patched, to).not_held}
    assert rows["motor_1", "rotor inertia"] == "60 kg m2"
    assert rows["motor_1", "stiffness of the gear"] == "200000 Nm/rad"
    assert rows["motor_2", "delay"] == "0.003 s"
    assert rows["motor_1", "backlash"] == "gap 0.001 rad"


def test_missing_dynamics_are_added(patched: PatchedRobot, tmp_path: Path) -> None:
    for to in ("urdf", "sdf"):
        text = export_model(load_patched("elbow"), to).text
        lines = [line for line in text.splitlines() if "dynamics" not in line and "damping" not in line]
        exported = export_model(patched, to, base_file(tmp_path, to, "\n".join(lines)))
        assert value(exported, to, "motor_1", "damping") == 60


def test_wrong_format_is_refused(patched: PatchedRobot, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="<robot>"):
        export_model(patched, "sdf", base_file(tmp_path, "urdf"))


def test_motor_side_values_need_a_format_with_a_gear() -> None:
    with pytest.raises(InputError, match="motor side") as caught:
        export_model(load_patched("four_mass"), "urdf")
    assert caught.value.argument == "to"


def test_an_imported_urdf_finds_its_joints_again(tmp_path: Path) -> None:
    base, robot = tmp_path / "base.urdf", tmp_path / "robot.yaml"
    text = (
        export_model(load_patched("elbow"), "urdf")
        .text.replace('"motor_1"', '"shoulder"')
        .replace('"motor_2"', '"fore"')
    )
    base.write_text(text)
    robot.write_text(robot_from_urdf(base).text)
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: robot.yaml\neffects:\n  - {effect: coulomb_friction, location: motor_2, parameters: {level: 7}}\n"
    )
    exported = export_model(load_patched(patch), "urdf", base)
    assert [(row.place, row.value) for row in exported.written] == [("joint fore dynamics friction", 7)]


@pytest.mark.parametrize("to", ["urdf", "json"])
def test_what_is_listed_counts_as_the_joint_of_the_file_does(to: Format, tmp_path: Path) -> None:
    base, robot, patch = tmp_path / "base.urdf", tmp_path / "robot.yaml", tmp_path / "patch.yaml"
    base.write_text(export_model(load_patched("elbow"), "urdf").text.replace('axis xyz="0 1 0"', 'axis xyz="0 -1 0"'))
    robot.write_text(robot_from_urdf(base).text)
    bias = "{effect: torque_bias, location: motor_2, parameters: {level: 0.26}}"
    offset = "{effect: encoder_offset, location: motor_1, parameters: {offset: 0.05}}"
    patch.write_text(f"robot: robot.yaml\neffects: [{bias}, {offset}]\n")
    exported = export_model(load_patched(patch), to, base if to == "urdf" else None)
    listed = {row.name: row.size for row in exported.not_held}
    listed |= {row.quantity: f"{row.value:g} {row.unit}" for row in exported.written if row.location == "motor_1"}
    assert listed["torque_bias"] == "level -0.26 Nm"
    assert listed["zero of the encoder"] == "-0.05 rad"


def test_a_number_that_is_none_is_named(patched: PatchedRobot, tmp_path: Path) -> None:
    text = export_model(load_patched("elbow"), "urdf").text.replace('damping="60"', 'damping="much"')
    with pytest.raises(InputError, match="joint motor_1 dynamics damping is 'much'"):
        export_model(patched, "urdf", base_file(tmp_path, "urdf", text))


INERTIA = '<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'


def link(name: str, mass: float) -> str:
    return f'<link name="{name}"><inertial><mass value="{mass}"/>{INERTIA}</inertial></link>'


def joint(name: str, parent: str, child: str, kind: str = "continuous") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>'
    return f'<joint name="{name}" type="{kind}">{ends}</joint>'


def test_what_is_fixed_to_a_body_is_scaled_with_it(tmp_path: Path) -> None:
    urdf, model, file = tmp_path / "r.urdf", tmp_path / "r.yaml", tmp_path / "p.yaml"
    parts = (link("l1", 1), link("tool", 2), joint("j1", "base", "l1"), joint("f", "l1", "tool", "fixed"))
    urdf.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    model.write_text(robot_from_urdf(urdf, tip="l1").text)
    file.write_text(
        f"robot: {model}\neffects:\n  - {{effect: payload_error, location: tool, parameters: {{relative: 0.5}}}}\n"
    )
    root = ElementTree.fromstring(export_model(load_patched(file), "urdf", urdf).text)
    assert sum(float(mass.get("value", "0")) for mass in root.iter("mass")) == pytest.approx(4.5)


SHOULDER, ELBOW = joint("shoulder", "base", "l1"), joint("elbow", "l1", "l2")


def of_two(*joints: str) -> str:
    return f'<robot name="r"><link name="base"/>{joints[0]}{link("l1", 1)}{link("l2", 1)}{joints[1]}</robot>'


@pytest.mark.parametrize("joints", [(SHOULDER, ELBOW), (ELBOW, SHOULDER)])
def test_joints_are_those_in_the_order_of_the_chain_not_of_the_file(
    joints: tuple[str, str], patched: PatchedRobot, tmp_path: Path
) -> None:
    exported = export_model(patched, "urdf", base_file(tmp_path, "urdf", of_two(*joints)))
    assert value(exported, "urdf", "shoulder", "friction") == 12
    assert float(value(exported, "urdf", "elbow", "damping")) > 0


def test_a_new_limit_has_a_velocity_which_readers_require(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(
        "robot: elbow\neffects:\n  - {effect: torque_saturation, location: motor_1, parameters: {limit: 5}}\n"
    )
    text = of_two(SHOULDER, ELBOW)
    root = ElementTree.fromstring(export_model(load_patched(file), "urdf", base_file(tmp_path, "urdf", text)).text)
    limit = next(each for each in root.iter("joint") if each.get("name") == "shoulder").find("limit")
    assert limit is not None
    assert float(limit.get("effort", "")) == 5
    assert float(limit.get("velocity", "")) > 0
