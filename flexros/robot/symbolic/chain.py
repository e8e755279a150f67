"""The serial chain as a list of single joints, and its mapping to arm and motor coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import casadi as ca
import numpy as np

from flexros.arrays import FloatArray

if TYPE_CHECKING:
    from flexros.robot.specification import Direction, Motor, RobotSpecification

Coordinates = TypeVar("Coordinates", FloatArray, ca.SX)
"""Numerical or symbolic coordinates."""


@dataclass(frozen=True)
class Joint:
    """One direction of motion.

    Attributes:
        name: Arm coordinate, e.g. "body_1.ry".
        axis: Index of the coordinate axis, 0 to 2.
        rotary: Rotation (True) or translation (False).
        body: Index of the body that it belongs to.
        first: Whether it is the first joint of the body, offset by the length of the body before.
        last: Whether it is the last joint of the body, which carries the mass.
        direction: Its entry in the robot file.
        motor: Index of its motor, None when not actuated.
        motor_coordinate: Index of the motor's own coordinate among the motor coordinates; None for a rigid gear
            (the motor moves with the arm coordinate) and when not actuated.
    """

    name: str
    axis: int
    rotary: bool
    body: int
    first: bool
    last: bool
    direction: Direction
    motor: int | None
    motor_coordinate: int | None


@dataclass(frozen=True)
class Chain:
    """Serial chain of joints; bodies without a free direction are carried by the joint before them.

    Attributes:
        joints: Joints from base to tool, one per arm coordinate.
        n_motors: Number of motors, M.
        n_motor_coordinates: Number of motors behind a flexible gear.
    """

    joints: tuple[Joint, ...]
    n_motors: int
    n_motor_coordinates: int

    @property
    def gear_rows(self) -> tuple[int, ...]:
        """Row of each motor's gear coordinate among the coordinates q = [q_a, q_m], shape (M,)."""
        return tuple(index for index, joint in enumerate(self.joints) if joint.motor is not None)

    @property
    def flexible_motors(self) -> tuple[int, ...]:
        """Indices of the motors behind flexible gears, in the order of their own coordinates."""
        return tuple(k for k, arm in enumerate(self.gear_rows) if self.joints[arm].motor_coordinate is not None)

    @property
    def stiff_motors(self) -> tuple[int, ...]:
        """Indices of the motors behind rigid gears, which move with their arm coordinates."""
        return tuple(k for k, arm in enumerate(self.gear_rows) if self.joints[arm].motor_coordinate is None)

    @property
    def spring_rows(self) -> tuple[int, ...]:
        """Rows of the coordinates with a spring: all but those behind a rigid gear."""
        stiff = {self.gear_rows[number] for number in self.stiff_motors}
        return tuple(index for index in range(len(self.joints)) if index not in stiff)

    @property
    def motor_rows(self) -> tuple[int, ...]:
        """Row of each motor's position among the coordinates q = [q_a, q_m], shape (M,)."""
        own = {motor: len(self.joints) + index for index, motor in enumerate(self.flexible_motors)}
        return tuple(own.get(motor, row) for motor, row in enumerate(self.gear_rows))

    def arm_from_gears(self, gears: Coordinates) -> Coordinates:
        """Embed gear coordinates (or their rates) in arm coordinates, with elastic directions at zero.

        Args:
            gears: Gear coordinates [rad or m], shape (..., M), or SX (M, 1).

        Returns:
            Arm coordinates [rad or m], shape (..., N), or SX (N, 1).
        """
        if isinstance(gears, ca.SX):
            symbolic: Coordinates = ca.SX.zeros(len(self.joints))
            for motor, row in enumerate(self.gear_rows):
                symbolic[row] = gears[motor]
            return symbolic
        arm: Coordinates = np.zeros((*gears.shape[:-1], len(self.joints)))
        arm[..., list(self.gear_rows)] = gears
        return arm

    def motor(self, number: int) -> Motor:
        """Return the entry of a motor in the robot file."""
        motor = self.joints[self.gear_rows[number]].direction.motor
        assert motor is not None
        return motor


def build_chain(specification: RobotSpecification) -> Chain:
    """Build the chain of a robot."""
    joints: list[Joint] = []
    n_motors = n_motor_coordinates = 0
    for body_index, body in enumerate(specification.bodies):
        free = [(axis, d) for axis, d in body.directions.items() if d.motor or d.spring != "rigid"]
        for position, (axis, direction) in enumerate(free):
            flexible = direction.motor is not None and direction.spring != "rigid"
            joints.append(
                Joint(
                    name=f"body_{body_index + 1}.{axis}",
                    axis="xyz".index(axis[1]),
                    rotary=axis[0] == "r",
                    body=body_index,
                    first=position == 0,
                    last=position == len(free) - 1,
                    direction=direction,
                    motor=n_motors if direction.motor else None,
                    motor_coordinate=n_motor_coordinates if flexible else None,
                )
            )
            n_motors += direction.motor is not None
            n_motor_coordinates += flexible
    return Chain(tuple(joints), n_motors, n_motor_coordinates)
