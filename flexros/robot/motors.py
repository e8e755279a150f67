"""The motors of a robot: name, joint, units and ratings of each, rotary or prismatic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from flexros.robot.specification import Motor
    from flexros.robot.symbolic.chain import Chain, Joint


@dataclass(frozen=True)
class RobotMotor:
    """One motor of a robot.

    Attributes:
        name: Name in messages, e.g. "motor_1".
        index: Index among the motors, from 0.
        joint: The joint behind its gear.
        gear_row: Row of the gear coordinate among the coordinates q = [q_a, q_m].
        row: Row of the motor position among q; that of the gear where the gear is rigid.
        specification: Its entry in the robot file.
    """

    name: str
    index: int
    joint: Joint
    gear_row: int
    row: int
    specification: Motor

    @property
    def rotary(self) -> bool:
        """Rotary (True) or prismatic (False)."""
        return self.joint.rotary

    @property
    def flexible(self) -> bool:
        """Whether the gear is flexible, so that the motor has a coordinate of its own."""
        return self.joint.motor_coordinate is not None

    @property
    def position_unit(self) -> str:
        """Unit of its position, "rad" or "m"."""
        return self.unit("position")

    @property
    def torque_unit(self) -> str:
        """Unit of its torque, "Nm" or "N"."""
        return self.unit("torque")

    def unit(self, kind: str) -> str:
        """Return the SI unit of a kind of quantity, e.g. "damping"; see `flexros.robot.quantity.UNITS`."""
        return unit_of(kind, self.rotary)

    @property
    def gear_ratio(self) -> float:
        """Motor turns per arm turn."""
        return self.specification.gear_ratio.value

    @property
    def inertia(self) -> float:
        """Rotor inertia [kg m2 or kg], on the side of the gear that the robot file states."""
        return self.specification.inertia.value

    @property
    def torque_limit(self) -> float:
        """Largest absolute torque [Nm or N], infinite for no limit."""
        limit = self.specification.torque_limit
        return math.inf if limit is None else limit.value

    @property
    def speed_limit(self) -> float:
        """Largest speed of the direction that it moves [rad/s or m/s], infinite for no limit."""
        limit = self.specification.speed_limit
        return math.inf if limit is None else limit.value


def list_motors(chain: Chain) -> tuple[RobotMotor, ...]:
    """List the motors of a chain of joints, in order."""
    return tuple(
        RobotMotor(f"motor_{index + 1}", index, chain.joints[gear_row], gear_row, row, chain.motor(index))
        for index, (gear_row, row) in enumerate(zip(chain.gear_rows, chain.motor_rows, strict=True))
    )
