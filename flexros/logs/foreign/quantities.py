"""Quantities of the columns of a foreign log, their topics and fields, and their units."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Quantity:
    """Topic and field of a quantity.

    Attributes:
        topic: Topic of `topics.yaml`.
        field: Field of its messages, such as "position" or "effort".
        kind: Kind of its unit: "position", "velocity", "torque", "acceleration" or "turning rate".
        of_tool: Whether it is one of the tool, along an axis, instead of one of a joint.
        beyond_motor: Whether it is added to the position of the motor: a deflection.
        drives: Whether it drives the robot, so that no joint of its topic may lack it.
    """

    topic: str
    field: str
    kind: str
    of_tool: bool = False
    beyond_motor: bool = False
    drives: bool = False


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        "position": Quantity("joint_states", "position", "position"),
        "velocity": Quantity("joint_states", "velocity", "velocity"),
        "measured_torque": Quantity("joint_states", "effort", "torque"),
        "torque_command": Quantity("joint_commands", "effort", "torque", drives=True),
        "position_command": Quantity("joint_commands", "position", "position", drives=True),
        "velocity_command": Quantity("joint_commands", "velocity", "velocity"),
        "reference_position": Quantity("joint_reference", "position", "position"),
        "reference_velocity": Quantity("joint_reference", "velocity", "velocity"),
        "feedforward_torque": Quantity("joint_reference", "effort", "torque"),
        "link_position": Quantity("link_states", "position", "position"),
        "link_deflection": Quantity("link_states", "position", "position", beyond_motor=True),
        "link_velocity": Quantity("link_states", "velocity", "velocity"),
        "joint_torque": Quantity("link_states", "effort", "torque"),
        "tool_acceleration": Quantity("tool_imu", "linear_acceleration", "acceleration", of_tool=True),
        "tool_turning_rate": Quantity("tool_imu", "angular_velocity", "turning rate", of_tool=True),
    }
)
"""Every quantity that a mapping file may name."""


STANDARD_GRAVITY = 9.80665
"""Acceleration of the unit g [m/s^2]."""


@dataclass(frozen=True)
class Unit:
    """One unit of a kind of quantity.

    Attributes:
        kind: "position", "velocity", "torque", "acceleration" or "turning rate".
        rotary: Whether it is a unit of rotation; otherwise of translation.
        factor: Its size in the SI unit.
    """

    kind: str
    rotary: bool
    factor: float


UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        "rad": Unit("position", True, 1.0),
        "mrad": Unit("position", True, 1e-3),
        "deg": Unit("position", True, pi / 180),
        "turn": Unit("position", True, 2 * pi),
        "m": Unit("position", False, 1.0),
        "mm": Unit("position", False, 1e-3),
        "um": Unit("position", False, 1e-6),
        "rad/s": Unit("velocity", True, 1.0),
        "deg/s": Unit("velocity", True, pi / 180),
        "rpm": Unit("velocity", True, 2 * pi / 60),
        "turn/s": Unit("velocity", True, 2 * pi),
        "m/s": Unit("velocity", False, 1.0),
        "mm/s": Unit("velocity", False, 1e-3),
        "Nm": Unit("torque", True, 1.0),
        "mNm": Unit("torque", True, 1e-3),
        "kNm": Unit("torque", True, 1e3),
        "N": Unit("torque", False, 1.0),
        "kN": Unit("torque", False, 1e3),
        "m/s2": Unit("acceleration", False, 1.0),
        "mm/s2": Unit("acceleration", False, 1e-3),
        "g": Unit("acceleration", False, STANDARD_GRAVITY),
    }
)
"""Units that need no scale; a scale converts every other unit (V, A, counts, ...) to one of these."""

TIME_UNITS: Mapping[str, float] = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9})
"""Seconds in one unit of a time column."""


def units_of(kind: str) -> list[str]:
    """List the units of a kind of quantity, those of rotations first."""
    if kind == "turning rate":
        return [name for name, unit in UNITS.items() if unit.kind == "velocity" and unit.rotary]
    return [name for name, unit in UNITS.items() if unit.kind == kind]
