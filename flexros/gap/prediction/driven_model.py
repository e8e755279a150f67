"""The model of a diagnosis as its log drives it: by torques, positions of servos, or the motion of some joints."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.record.prescribed_motion import INERTIA

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.record.record import Record


def driven_model(model: RobotWithEffects, record: Record) -> RobotWithEffects:
    """Return a model with the input of a log; motors whose motion is prescribed have an endless inertia and no laws.

    Args:
        model: The model.
        record: The log.

    Raises:
        InputError: Positions are commanded, and a motor has no servo in the robot file.
    """
    model = model.commanded_by(record.commands)
    if not record.prescribed:
        return model
    if model.robot.spec.inertial_coupling:
        raise InputError(
            f"{record.name}: the motion of a motor of robot {model.robot.name} is prescribed, but its rotors turn with "
            "the links (inertial_coupling), so that torques of all motors matter; leave inertial_coupling out"
        )
    names = prescribed_names(model, record)
    values = {f"{name}.{number}": value for name in names for number, value in _NUMBERS.items()}
    laws = tuple(law for law in model.laws if law.location not in names)
    return replace(model, robot=model.robot.with_values(values, "prescribed motion"), laws=laws)


def prescribed_names(model: RobotWithEffects, record: Record) -> frozenset[str]:
    """Return the names of the motors whose motion is prescribed.

    Args:
        model: The model.
        record: The log.
    """
    return frozenset(model.robot.joint_names[motor] for motor in record.prescribed)


_NUMBERS = {"inertia": INERTIA, "viscous_friction": 0.0}
"""Numbers of a motor whose motion is prescribed [SI]."""
