"""Wrong zero of an encoder."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.sensor import AbstractSensor

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi as ca

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value

POSES = 6
"""Poses in which the torque is compared [1] (chosen): weights that cancel in one do not in all."""
FELT = 1e-9
"""Change of a torque, over the largest one, from which it depends on a position [1]: above rounding."""


class EncoderOffset(AbstractSensor):
    """A constant error of the measured position: a wrong zero or home position.

    With the offset d the measurement is d larger than the position. The arm is then elsewhere than the model has it,
    and what shows is its weight and its inertia there. Around a vertical axis of the first joint, and along an axis, no
    torque depends on the position, so that a diagnosis does not seek one there. A servo acts on what its encoder
    measures, so that it brings the measured position to the command, and the arm elsewhere: the horn of a hobby servo
    that is put on one tooth beside.

    Reference: Hollerbach, Khalil, Gautier 2016, Springer Handbook of Robotics, chapter 8: joint offsets.
    """

    name: ClassVar[str] = "encoder_offset"
    stage: ClassVar[Stage] = "sensor"
    sought_where: ClassVar[str] = "where a torque of the robot depends on the position"
    size: ClassVar[str] = "offset"
    turned: ClassVar[tuple[str, ...]] = ("offset",)
    rank: ClassVar[int] = 0
    plain: ClassVar[bool] = True
    taken_for: ClassVar[tuple[str, ...]] = ("torque_bias",)
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position",)
    fingerprint: ClassVar[str] = (
        "disturbance torques in several joints as if the weight of the arm beyond one joint were turned by a constant "
        "angle, independent of direction and speed"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"offset": Range("relative", 1e-4, 0.2, starts=2, signed=True, source="chosen [rad or m]", widest=2.0)}
    )

    offset: float = Field(0.0, description="measured minus true position, of the motor coordinate [rad or m]")

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether a torque of the robot depends on the position of the motor."""
        return robot.joint_names.index(location) in _felt(robot)

    def constant_error(self) -> float:
        """Return the offset."""
        return self.offset

    def read(self, position: ca.SX, angle: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Add the offset."""
        del angle
        return position + values["offset"]


@lru_cache(maxsize=64)
def _felt(robot: Robot) -> frozenset[int]:
    """Return the motors whose position the torques of a robot depend on, with all gears locked."""
    rng = np.random.default_rng(0)
    motion = [rng.uniform(-1.0, 1.0, (POSES, robot.n_motors)) for _ in range(3)]
    nominal = _torques(robot, *motion)
    largest = float(np.abs(nominal).max())
    found = set()
    for motor in range(robot.n_motors):
        moved = motion[0].copy()
        moved[:, motor] += 0.3
        if np.abs(_torques(robot, moved, *motion[1:]) - nominal).max() > FELT * largest:
            found.add(motor)
    return frozenset(found)


def _torques(robot: Robot, *motion: np.ndarray) -> np.ndarray:
    """Return the torques of the gears in a motion of theirs [Nm or N], shape (M, POSES)."""
    arm = robot.arm_from_gears(np.eye(robot.n_motors))
    q, v, a = ((row @ arm).T for row in motion)
    torques = np.asarray(robot.model.arm_inverse_dynamics(q, v, a, robot.model.parameter_values), dtype=float)
    return torques[list(robot.gear_rows)]
