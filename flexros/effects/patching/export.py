"""Export of a robot with its effects to other simulators, and the patch of an imported robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from flexros.config.text_file import read_text
from flexros.effects.patching.patch import Patch, PatchedEffect, PatchedValue
from flexros.effects.patching.repaired_numbers import joint_side, repaired_numbers
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.exchange.joint_names import all_turned_round
from flexros.robot.exchange.json_export import json_export
from flexros.robot.exchange.mjcf.base_file import mjcf_base
from flexros.robot.exchange.mjcf.export import mjcf_export
from flexros.robot.exchange.mjcf.repair import repair_mjcf
from flexros.robot.exchange.urdf.description_repair import repair_description
from flexros.robot.exchange.urdf.export import urdf_text
from flexros.robot.exchange.urdf.sdf_export import sdf_text

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flexros.effects.patching.patched_robot import PatchedRobot
    from flexros.robot.exchange.imported import ImportedRobot
    from flexros.robot.exchange.numbers import Export

Format = Literal["mjcf", "urdf", "sdf", "json"]

FORMATS: tuple[Format, ...] = ("mjcf", "urdf", "sdf", "json")


def export_model(
    patched: PatchedRobot,
    to: Format,
    base: Path | None = None,
    joints: Mapping[str, str] | None = None,
    end: str = "",
) -> Export:
    """Return a robot with its effects in the format of another program.

    Args:
        patched: Robot with effects, as loaded.
        to: The format.
        base: The user's own file of this format, in which only the numbers are changed; default: a new file.
        joints: Joint of that file by motor; default: as in `flexros.robot.exchange.joint_names.motor_joints`.
        end: Body at the end of the arm in an MJCF; default: the only possible one.

    Raises:
        InputError: The base cannot be used, or values of the robot file are stated on the motor side and the format
            has no place for the gear ratio.
    """
    robot, named = patched.model.robot, joints or {}
    if to == "mjcf" and base is not None:
        file = mjcf_base(base, robot, named, end)
        return repair_mjcf(file, robot, repaired_numbers(patched, turned=file.turned))
    of_file = base is not None or to == "json"  # new files of the others have the joints of the robot file
    numbers = repaired_numbers(patched, turned=all_turned_round(robot) if of_file else ())
    if to == "json":
        if base is not None:
            raise InputError(f"a JSON of joint numbers is written anew, so {base} is of no use; leave it out", "base")
        return json_export(robot, numbers, named)
    if to == "mjcf":
        return mjcf_export(robot, numbers)
    if base is not None:
        return repair_description(read_text(base, to.upper(), LARGEST_URDF), str(base), to, robot, numbers, named)
    if joint_side(robot) != 1:
        raise InputError(
            f"robot {robot.name} states values on the motor side of its gear, which a new {to.upper()} cannot; choose "
            "mjcf or json, or give a base",
            "to",
        )
    text = urdf_text(robot) if to == "urdf" else sdf_text(robot)
    own = {motor: motor for motor in robot.joint_names}
    return repair_description(text, robot.name, to, robot, numbers, own, new=True)


def patch_of_import(imported: ImportedRobot, robot: str) -> Patch | None:
    """Return the patch with what the robot file of an import cannot state; None where there is nothing.

    Args:
        imported: The imported robot.
        robot: Its robot file, relative to the folder of the patch.
    """
    if not imported.effects:
        return None
    effects = tuple(
        PatchedEffect(
            effect=each.effect,
            location=each.location,
            parameters={each.parameter: PatchedValue(value=each.value, unit=each.unit)},
        )
        for each in imported.effects
    )
    return Patch(robot=robot, source="numbers of the imported file that a robot file does not have", effects=effects)
