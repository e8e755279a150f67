"""A load at the end of the arm that the robot file leaves out."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range
from flexros.robot.parameters import INERTIA_COMPONENTS
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot

ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Row and column of each entry of an inertia."""

PARALLEL = 1e-3
"""Angle up to which two axes are parallel [rad] (chosen): files round right angles."""


class ToolLoad(AbstractChangedValues):
    """A point mass on the last body that moves, such as a tool that the model lacks.

    With mass m_0, centre of mass c_0 and inertia I_0 of the body and mass m at c, the body has the mass m_0 + m, the
    centre of mass (m_0 c_0 + m c) / (m_0 + m) and the inertia of both about it. A model made from a URDF is that of the
    bare arm: a diagnosis estimates the load there from the torques, as a number that is unknown. Logs of servos have no
    torques: there the load is a candidate like others. Where the load is known but wrong, that is a payload error.
    """

    name: ClassVar[str] = "tool_load"
    stage: ClassVar[Stage] = "load"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position", "torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "a disturbance torque in all joints by the weight of a mass at one point of the last body, and by its "
        "acceleration"
    )

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "mass": Range("relative", 1e-3, 30.0, 3, source="chosen [kg]: from a pen to the load of a large arm"),
            **{
                axis: Range("relative", 1e-3, 1.0, (0.0,), signed=True, source="chosen [m]", vanishes="never")
                for axis in "xyz"
            },
        }
    )

    mass: float = Field(0.0, ge=0.0, description="mass [kg]")
    x: float = Field(0.0, description="its place from the last joint, along x of the frame of the body [m]")
    y: float = Field(0.0, description="the same along y [m]")
    z: float = Field(0.0, description="the same along z [m]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the tool, the only location of a load, on robots whose last body turns or slides."""
        return ("tool",) if last_moved(robot) else ()

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether several servos move the robot under gravity.

        Other logs have torques, which show the load. What a load does to a single servo, other gains do as well.
        """
        del location
        return robot.commands == "position" and robot.n_motors > 1 and any(robot.spec.gravity.value)

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return the same, or whether springs blur what the torques show of a load of several motors."""
        return self.sought(robot, location) or (bool(robot.flexible_motors) and robot.n_motors > 1)

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return mass and place, without the coordinate along an axis about which all joints turn: nothing shows it."""
        del location
        seen = seen_axes(robot, last_moved(robot))
        return {name: allowed for name, allowed in self.ranges.items() if name not in "xyz" or name in seen}

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return mass, centre of mass and inertia of the last body that moves, with the load."""
        del location
        body = last_moved(robot)
        own, center, inertia = body_numbers(robot, body)
        if self.mass == 0:
            return {}
        place = np.array([self.x, self.y, self.z])
        mass = own + self.mass
        common = (own * center + self.mass * place) / mass
        inertia = inertia + point_inertia(own, center - common) + point_inertia(self.mass, place - common)
        found = {f"{body}.mass": mass}
        found |= {f"{body}.center_of_mass.{axis}": float(value) for axis, value in zip("xyz", common, strict=True)}
        return found | {f"{body}.inertia.{entry}": float(inertia[ENTRIES[entry]]) for entry in INERTIA_COMPONENTS}


def seen_axes(robot: Robot, body: str = "") -> tuple[str, ...]:
    """Return the axes along which a log shows where a mass is: not the one about which all joints turn.

    Args:
        robot: The robot.
        body: The body in whose frame the axes are, e.g. "body_7"; default: the base.
    """
    if any(joint.mode is not None for joint in robot.joints):
        return tuple("xyz")
    frame = own = np.eye(3)
    turning = []
    for joint in robot.joints:
        frame = frame @ joint.turn
        turning += [frame[:, joint.axis]] if joint.rotary else []
        own = frame if body and joint.body < int(body.removeprefix("body_")) else own
    if not turning:
        return ()
    if not all(np.allclose(np.cross(axis, turning[0]), 0.0, atol=PARALLEL) for axis in turning):
        return tuple("xyz")
    return tuple(axis for axis, part in zip("xyz", own.T @ turning[0]) if 1.0 - part**2 > PARALLEL**2)


def last_moved(robot: Robot) -> str:
    """Return the last body that moves by a direction of its own, e.g. "body_7"; empty where there is none.

    Args:
        robot: The robot.
    """
    moved = [f"body_{k}" for k, body in enumerate(robot.spec.bodies, start=1) if body.directions]
    return moved[-1] if moved else ""


def body_numbers(robot: Robot, body: str) -> tuple[float, FloatArray, FloatArray]:
    """Return mass [kg], centre of mass [m], shape (3,), and inertia about it [kg m2], shape (3, 3), of a body.

    Args:
        robot: The robot.
        body: The body, e.g. "body_7".
    """
    values = {name: parameter.value for name, parameter in robot.parameters.items() if name.startswith(f"{body}.")}
    center = np.array([values[f"{body}.center_of_mass.{axis}"] for axis in "xyz"])
    inertia = np.zeros((3, 3))
    for entry, (row, column) in ENTRIES.items():
        inertia[row, column] = inertia[column, row] = values[f"{body}.inertia.{entry}"]
    return values[f"{body}.mass"], center, inertia
