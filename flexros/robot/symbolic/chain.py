"""The serial chain as a list of single joints, and its mapping to arm and motor coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import casadi as ca
import numpy as np

from flexros.arrays import FloatArray
from flexros.robot.specification import Direction, bending_name
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from flexros.robot.beam import ModeShape
    from flexros.robot.specification import Body, Motor, RobotSpecification

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
        mode: Assumed mode of a link that bends, whose coordinate is its largest deflection [m]; None for a direction.
        orientation: Roll, pitch and yaw of its frame at zero from the frame before it [rad].
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
    mode: LinkMode | None = None
    orientation: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def turn(self) -> FloatArray:
        """Rotation at zero from its frame to the frame before it, R_z(yaw) R_y(pitch) R_x(roll), shape (3, 3)."""
        roll, pitch, yaw = (np.array([np.cos(angle), np.sin(angle)]) for angle in self.orientation)
        about_x = np.array([[1, 0, 0], [0, roll[0], -roll[1]], [0, roll[1], roll[0]]])
        about_y = np.array([[pitch[0], 0, pitch[1]], [0, 1, 0], [-pitch[1], 0, pitch[0]]])
        about_z = np.array([[yaw[0], -yaw[1], 0], [yaw[1], yaw[0], 0], [0, 0, 1]])
        return np.asarray(about_z @ about_y @ about_x)


@dataclass(frozen=True)
class LinkMode:
    """Assumed mode of a link as the motion of its tip.

    Attributes:
        shape: Deflection along the link.
        along: Index of the axis along the link.
        length: Length of the link with the sign of its direction [m].
        across: Index of the axis in which the link deflects.
        sign: Deflection along that axis by a positive slope, 1 or -1.
    """

    shape: ModeShape
    along: int
    length: float
    across: int
    sign: float

    @property
    def tip(self) -> float:
        """Deflection of the tip in units of the coordinate, along `across` [1]."""
        return float(self.at(np.ones(1))[0])

    @property
    def tip_slope(self) -> float:
        """Rotation of the tip about the bending axis per unit of the coordinate [rad/m]."""
        return float(self.shape.slope(np.ones(1))[0]) / abs(self.length)

    def at(self, xi: FloatArray) -> FloatArray:
        """Return the deflection along `across` at positions xi = x / l, in units of the coordinate [1]."""
        return self.sign * self.shape.deflection(xi)


def link_mode(axis: int, length: tuple[float, float, float], shape: ModeShape) -> LinkMode:
    """Return a mode of a link that bends about an axis.

    Args:
        axis: Index of the axis about which its slopes turn.
        length: Vector from the joint to the tip [m], along one axis.
        shape: Deflection along the link.
    """
    along = int(np.flatnonzero(length)[0])
    across = 3 - along - axis
    # a positive rotation about the axis moves the tip along axis x length
    sign = 1.0 if (axis + 1) % 3 == along else -1.0
    return LinkMode(shape, along, length[along], across, sign * float(np.sign(length[along])))


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
    def bends(self) -> bool:
        """Whether a link bends."""
        return any(joint.mode is not None for joint in self.joints)

    @property
    def turned(self) -> bool:
        """Whether frames are turned at zero, so that joints with the same axis need not be parallel."""
        return any(any(joint.orientation) for joint in self.joints)

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
                    orientation=body.orientation if position == 0 else (0.0, 0.0, 0.0),
                )
            )
            n_motors += direction.motor is not None
            n_motor_coordinates += flexible
        joints += _modes(body_index, body)
    return Chain(tuple(joints), n_motors, n_motor_coordinates)


def _modes(index: int, body: Body) -> list[Joint]:
    """Return the modes of a link as joints after those of its directions."""
    found = []
    for axis, bending in body.bending.items():
        for number, mode in enumerate(bending.listed()):
            found.append(
                Joint(
                    name=bending_name(index, axis, number),
                    axis="xyz".index(axis[1]),
                    rotary=False,
                    body=index,
                    first=False,
                    last=False,
                    direction=Direction(spring=Spring(stiffness=mode.stiffness), damper=mode.damping),
                    motor=None,
                    motor_coordinate=None,
                    mode=link_mode("xyz".index(axis[1]), body.length.value, mode.shape),
                )
            )
    return found
