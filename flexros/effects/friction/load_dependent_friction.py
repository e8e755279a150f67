"""Dry friction in proportion to the torque that a gear transmits."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from flexros.effects.kinds.dry_friction import AbstractDryFriction, FrictionLevels
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class LoadDependentFriction(AbstractDryFriction):
    """Dry friction at a motor in proportion to the torque that its gear transmits, with true sticking.

    With share s and transmitted torque T the torque on a moving motor is s |T| against the motion; at standstill it
    balances all other torques up to that level: the load term of Bittencourt and Gunnarsson 2012, Static Friction in a
    Robot Joint, J. Dyn. Sys. Meas. Control 134(5), and of Hamon, Gautier and Garrec 2010, Dynamic Identification of
    Robots with a Dry Friction Model Depending on Load and Velocity. A gear that drives its load then has the efficiency
    1 / (1 + s). Friction without load is Coulomb friction, a separate effect; the levels add.

    T is the torque of spring and damper, with all effects in the gear; behind a rigid gear what is left of the motor
    torque after friction and the acceleration of the rotor, which is the torque that the arm needs. It is taken in the
    middle of an integration step, extrapolated from its start, and held through it: of order two while the motor
    slides, of order one through reversals behind a rigid gear. A self-locking gear, s >= 1, is not represented.
    """

    name: ClassVar[str] = "load_dependent_friction"
    stage: ClassVar[Stage] = "motor friction"
    sought_where: ClassVar[str] = "behind a spring or under gravity"
    size: ClassVar[str] = "share"
    one_level: ClassVar[bool] = True
    needs_load: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed", "torque_after_reversal")
    fingerprint: ClassVar[str] = (
        "a disturbance torque against the motion that changes sign at each reversal and grows with the torque that the "
        "gear transmits: much where the arm is heavy or accelerates, little where it hangs"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "share": Range(
                "relative",
                1e-5,
                0.5,
                starts=5,
                widest=0.95,
                source="0.036 to 0.2 in servo gears (Duclusaud et al. 2024, BAM)",
            )
        }
    )

    share: float = Field(0.0, ge=0.0, lt=1.0, description="friction torque over the torque that the gear transmits [1]")

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the load of a gear can vary by itself: behind a spring, or under gravity.

        Behind a rigid gear without gravity the load is an inertia times the acceleration, which a log shows too weakly.
        """
        return robot.motors[robot.joint_names.index(location)].flexible or bool(np.any(robot.spec.gravity.value))

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the share of the load, the same in both directions."""
        level = ca.SX(values["share"] * ca.fabs(motor.load))
        return FrictionLevels(level, level)
