"""Slant of the base: gravity has another direction than in the robot file."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.spatial.transform import Rotation

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range
from flexros.effects.left_out.tool_load import seen_axes
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot

FIRST = 0.03
"""Initial slants about one axis each [rad] (chosen)."""
DIFFERENT = 0.1
"""Change of gravity by a rotation that nothing else makes, over that by one across it, from which torques show the
rotation [1] (chosen)."""

SET_UP = np.deg2rad(10.0)
"""Largest slant of a base that was set up carelessly [rad] (chosen)."""


class BaseTilt(AbstractChangedValues):
    """The base stands at a slant: the weight of the arm acts in another direction.

    With the base turned by the rotation vector r = (x, y, z) in its own frame, gravity in that frame is

        g' = exp(-[r]) g,

    with [r] a = r x a: its size is kept. A rotation about gravity changes nothing, and one about the axis of the first
    joint is an `encoder_offset` there, so that a diagnosis seeks neither.
    """

    name: ClassVar[str] = "base_tilt"
    words: ClassVar[str] = "tilt"
    stage: ClassVar[Stage] = "load"
    sought_where: ClassVar[str] = "in logs of real machines, of arms without springs"
    together: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position",)
    fingerprint: ClassVar[str] = (
        "disturbance torques in all joints as if the weight of the whole arm were turned by a constant angle, whatever "
        "its pose"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {axis: Range("relative", 1e-4, 0.8, (FIRST, -FIRST), signed=True, source="chosen [rad]") for axis in "xyz"}
    )

    x: float = Field(0.0, ge=-np.pi, le=np.pi, description="rotation of the base about its x axis [rad]")
    y: float = Field(0.0, ge=-np.pi, le=np.pi, description="the same about y [rad]")
    z: float = Field(0.0, ge=-np.pi, le=np.pi, description="the same about z [rad]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the base, on robots under gravity."""
        return ("base",) if any(robot.spec.gravity.value) else ()

    def sought(self, robot: Robot, location: str) -> bool:
        """Return False: a simulated robot stands as its model does."""
        del robot, location
        return False

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return whether a rigid arm shows a slant: by its torques, or by how far servos give way to its weight.

        Where little else is missing, torques show it at once, see `flexros.gap.fit.torques.turned_weight`. Springs
        blur what weight does.
        """
        return not robot.flexible_motors and bool(self.fitted(robot, location))

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the rotations that torques show, about one axis at a time in the initial values."""
        del location
        axes = _shown(robot)
        starts = FIRST * np.kron(np.eye(len(axes)), [1.0, -1.0])
        return {axis: replace(self.ranges[axis], starts=tuple(own)) for axis, own in zip(axes, starts.tolist())}

    def stands_for(self) -> str:
        """Return what turns gravity by more than a base that was set up carelessly."""
        angle = float(np.linalg.norm([self.x, self.y, self.z]))
        if angle <= SET_UP:
            return ""
        return (
            f"turns gravity by {np.rad2deg(angle):.0f} deg, which no base is set up wrongly by: either it is mounted "
            "otherwise than the robot file says, which the list gravity states there, or a force acts that is not in "
            "the library, such as that of a hose or a tether, which a turned weight imitates"
        )

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return gravity in the frame of the base."""
        del location
        turned = Rotation.from_rotvec([self.x, self.y, self.z]).inv().apply(robot.spec.gravity.value)
        return dict(zip(GRAVITY, turned.tolist(), strict=True))


def _shown(robot: Robot) -> tuple[str, ...]:
    """Return the axes about which rotations of the base change torques as no zero of the first joint does.

    Those that turn gravity most come first. Gravity along an axis about which all joints turn is not felt.
    """
    gravity, seen = np.array(robot.spec.gravity.value, dtype=float), seen_axes(robot)
    known: list[FloatArray] = [axis for axis, name in zip(np.eye(3), "xyz") if name not in seen]

    def is_new(axis: FloatArray) -> bool:
        change = np.cross(axis, gravity)
        rest = change - sum((change @ one * one for one in known), start=np.zeros(3))
        size = float(np.linalg.norm(rest))
        if size <= DIFFERENT * np.linalg.norm(gravity):
            return False
        known.append(rest / size)
        return True

    first = robot.joints[0]
    if first.rotary:
        is_new(first.turn[:, first.axis])
    found = {int(k) for k in np.argsort(np.abs(gravity), kind="stable") if is_new(np.eye(3)[k])}
    return tuple(name for k, name in enumerate("xyz") if k in found)
