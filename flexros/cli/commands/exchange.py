"""Commands that exchange robots with other simulators: import of a URDF or an MJCF, export of repaired numbers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.model import ROBOT
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects.patching.patched_robot import PatchedRobot
    from flexros.robot.exchange.imported import ImportedJoint, ImportedRobot
    from flexros.robot.exchange.numbers import NotHeld


def import_urdf(
    file: Path = typer.Argument(help="URDF."),
    out: Path = typer.Option(..., "--out", help="Robot YAML to write."),
    tip: str = typer.Option("", "--tip", help="Last link of the arm, for a URDF with several chains, as of a gripper."),
    patch: Path = typer.Option(
        None, "--patch", help="Patch to write with the dry friction of the URDF; default: OUT with _patch."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Convert a URDF to a robot YAML, springs to be filled in, and its dry friction to a patch of it."""
    from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

    with working("reading the URDF"):
        imported = robot_from_urdf(file, tip, out.parent)
        second, effects = _write_import(imported, out, patch)
    if as_json:
        _print_import(imported, out, second)
        return
    _print_joints(imported.joints)
    for note in imported.notes:
        say(note)
    say(f"{out} written with rigid gears; where one is elastic, replace its 'rigid' by the stiffness")
    if second:
        say(f"{second} written: {effects}; give it as the model where this friction counts")


def import_mjcf(
    file: Path = typer.Argument(help="MJCF of MuJoCo with a serial arm of hinges and slides on a fixed base."),
    out: Path = typer.Option(..., "--out", help="Robot YAML to write."),
    patch: Path = typer.Option(
        None, "--patch", help="Patch to write with what a robot file cannot state; default: OUT with _patch."
    ),
    end: str = typer.Option("", "--end", help="Body at the end of the arm; needed where there are several chains."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Convert an MJCF to a robot YAML, and its dry friction, lags and delays to a patch of it."""
    from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf

    with working("reading the MJCF"):
        imported = robot_from_mjcf(file, end)
        second, effects = _write_import(imported, out, patch)
    if as_json:
        _print_import(imported, out, second)
        return
    _print_joints(imported.joints)
    _print_not_held(imported.not_held, "Neither robot file nor patch holds:")
    for note in imported.notes:
        say(note)
    rigid = "; to make a gear elastic replace its 'rigid' by the stiffness" if "spring: rigid" in imported.text else ""
    say(f"{out} written{rigid}")
    if second:
        say(f"{second} written: {effects}")


def export(
    name: str = typer.Argument(help=ROBOT),
    to: str = typer.Option(..., "--to", help="Format: mjcf, urdf, sdf, or json of joint numbers."),
    out: Path = typer.Option(..., "--out", help="File to write."),
    base: Path = typer.Option(
        None, "--base", help="Your own MJCF, URDF or SDF: OUT is this file with the numbers of the robot."
    ),
    joint: list[str] = typer.Option(
        [], "--joint", help="MOTOR=JOINT, repeatable: joint of the base that a motor is; default: by name or order."
    ),
    end: str = typer.Option("", "--end", help="Body at the end of the arm in the MJCF of --base."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Write the numbers of a robot or patch where other simulators keep them, and list what they cannot hold."""
    from flexros.effects.patching.export import FORMATS, export_model
    from flexros.effects.patching.patched_robot import load_patched

    formats = {each: each for each in FORMATS}
    if to not in formats:
        raise unknown_name("format", to, formats, "--to")
    if base is not None and base.resolve() == out.resolve():
        raise InputError(f"{out} is the base itself, which is kept; give another file", "out")
    _refuse_existing(out)
    with working(f"writing the {to.upper()}"):
        patched = load_patched(name)
        exported = export_model(patched, formats[to], base, _joints(joint), end)
    write_result(out, exported.text, to.upper())
    if base is not None and out.resolve().parent != base.resolve().parent and " file=" in exported.text:
        text = f"flexros: {out} names files relative to its folder, but {base} is in another one; move it there"
        typer.echo(text, err=True)
    if as_json:
        content = {
            "out": str(out),
            "format": to,
            "base": None if base is None else str(base),
            "written": [asdict(each) for each in exported.written],
            "not_held": [asdict(each) for each in exported.not_held],
        }
        print_json(content)
        return
    table = Table("location", "quantity", "where", "before", "now", "unit")
    for each in exported.written:
        before = "" if each.before is None else f"{each.before:.6g}"
        table.add_row(each.location, each.quantity, each.place, before, f"{each.value:.6g}", each.unit)
    if exported.written:
        console.print(table)
    else:
        say(f"Nothing differs from {base}.")
    _print_not_held(exported.not_held, f"Not held by the {to.upper()}{_signs(patched, base)}:")
    say(f"{out} written")


def _signs(patched: PatchedRobot, base: Path | None) -> str:
    """Say that sizes count as the joints of the base, where some of these count against their motors."""
    from flexros.robot.exchange.joint_names import tagged, turned_round

    robot = patched.base
    opposite = [tagged(robot, motor) for motor in robot.joint_names if turned_round(robot, motor)]
    return f", with the signs of its joints ({', '.join(opposite)} against the motor)" if base and opposite else ""


def _joints(pairs: Sequence[str]) -> dict[str, str]:
    joints = {}
    for pair in pairs:
        motor, equals, joint = pair.partition("=")
        if not equals or not motor or not joint:
            raise InputError(f"'{pair}' is not MOTOR=JOINT; give for instance motor_1=shoulder_pan", "joint")
        joints[motor] = joint
    return joints


def _write_import(imported: ImportedRobot, out: Path, patch: Path | None) -> tuple[Path | None, str]:
    """Write the robot file, and a patch where there is something for it; return the path and effects of the patch."""
    from flexros.effects.patching.export import patch_of_import
    from flexros.effects.patching.patch import name_from

    second = patch or out.with_name(f"{out.stem}_patch.yaml")
    for path, argument in ((out, "out"), (second, "patch")):
        if path.suffix not in (".yaml", ".yml"):
            raise InputError(
                f"'{path}' does not end in .yaml, as robot files and patches do; give another name", argument
            )
        if not path.parent.is_dir():
            raise InputError(f"the folder '{path.parent}' of '{path}' does not exist; make it", argument)
    if second.resolve() == out.resolve():
        raise InputError(f"'{second}' is the robot file itself; give another name", "patch")
    made = patch_of_import(imported, name_from(str(out), second.parent))
    for path in (out, second) if made else (out,):
        _refuse_existing(path)
    write_result(out, imported.text, "robot file")
    if not made:
        return None, ""
    write_result(second, made.text(), "patch")
    return second, ", ".join(made.names)


def _print_import(imported: ImportedRobot, out: Path, patch: Path | None) -> None:
    content = {
        "robot": str(out),
        "patch": str(patch) if patch else None,
        "effects": [asdict(each) for each in imported.effects],
        "joints": [asdict(each) for each in imported.joints],
        "not_held": [asdict(each) for each in imported.not_held],
        "notes": list(imported.notes),
    }
    print_json(content)


def _print_joints(joints: Sequence[ImportedJoint]) -> None:
    table = Table("coordinate", "joint", "sign", "zero at")
    for joint in joints:
        table.add_row(joint.coordinate, joint.joint, f"{joint.sign:+d}", f"{joint.reference:.6g}")
    console.print(table)


def _refuse_existing(path: Path) -> None:
    if path.exists():
        raise InputError(f"{path} exists already; give another name or remove it")


def _print_not_held(entries: Sequence[NotHeld], title: str) -> None:
    if not entries:
        return
    say(title)
    table = Table("location", "what", "size", "why")
    for each in entries:
        table.add_row(each.location, each.name, each.size, each.reason)
    console.print(table)
