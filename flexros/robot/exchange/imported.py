"""A robot from an MJCF or a URDF: robot file, effects for what it cannot state, joints, and what neither holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.robot.exchange.numbers import NotHeld


TOLERANCE = 0.03
"""Tolerance that an imported robot file states for all numbers but lengths [1] (chosen)."""
LENGTH_TOLERANCE = 0.003
"""The same for the lengths of bodies [1] (chosen): they come from a drawing, and are known far better than masses."""


def import_defaults(source: str) -> dict[str, str | float]:
    """Return the `defaults` of an imported robot file.

    Args:
        source: Name of the file that it is made from.
    """
    return {"source": source, "tolerance": TOLERANCE, "length_tolerance": LENGTH_TOLERANCE}


@dataclass(frozen=True)
class ImportedEffect:
    """A number of the file that a robot file states as an effect.

    Attributes:
        effect: Name of the effect.
        location: Motor or body.
        parameter: Its parameter.
        value: Value of the parameter.
        unit: SI unit.
    """

    effect: str
    location: str
    parameter: str
    value: float
    unit: str


@dataclass(frozen=True)
class ImportedJoint:
    """How a coordinate of the robot follows from a joint of the file: sign (position - reference).

    Attributes:
        coordinate: Motor, or arm coordinate of a joint without an actuator; behind a motor the joint is the deflection
            of its gear, arm minus motor.
        joint: Name of the joint in the file.
        sign: Sign of the coordinate relative to the joint.
        reference: Joint position at the zero of the coordinate [rad or m].
    """

    coordinate: str
    joint: str
    sign: int
    reference: float


@dataclass(frozen=True)
class ImportedRobot:
    """A robot from a file of another program.

    Attributes:
        text: Robot file (YAML).
        effects: Numbers that belong in a patch.
        joints: Where the coordinates come from.
        not_held: Numbers that neither holds.
        notes: What the robot file holds otherwise than the file, in sentences.
    """

    text: str
    effects: tuple[ImportedEffect, ...]
    joints: tuple[ImportedJoint, ...]
    not_held: tuple[NotHeld, ...]
    notes: tuple[str, ...] = ()
