"""Torque periodic in the rotor angle: cogging and ripple."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.ranges import HIGHEST_ORDER, HarmonicEntry, Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot.symbolic.kinematics import Value

OVERTONE = ("second_sine", "second_cosine")
"""Parameters of what has twice the order, relative to the amplitude."""


class TorqueRipple(AbstractMotorTorque):
    """One order of a Fourier series in the rotor angle, and what has twice this order.

    With amplitude A, order n, phase p and rotor angle a, the torque A sin(n a + p) is added at the motor (cogging), or
    A sin(n a + p) times the torque that acts on it (ripple of a winding, `proportional`). The order counts periods per
    turn of the rotor: for a robot stated on the arm side the rotor angle is gear ratio times the motor coordinate, for
    one stated on the motor side the motor coordinate itself. Other orders are further effects.

    A wave that is no pure sine has an overtone as well, A (s sin(2 (n a + p)) + c cos(2 (n a + p))), with `second_sine`
    s and `second_cosine` c. A diagnosis fits it once the ripple is found, as small effects drown in it.
    """

    name: ClassVar[str] = "torque_ripple"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "amplitude"
    turned: ClassVar[tuple[str, ...]] = ("phase", "second_cosine")
    unsaid: ClassVar[tuple[str, ...]] = OVERTONE
    signatures: ClassVar[tuple[str, ...]] = ("order_spectrum", "torque_over_rotor_angle")
    harmonics: ClassVar[tuple[HarmonicEntry, ...]] = (
        HarmonicEntry("torque"),
        HarmonicEntry("proportional torque", (("proportional", True),), largest=0.99),  # such ripples are below 1
    )
    fingerprint: ClassVar[str] = (
        "a disturbance torque periodic in the motor angle, with the same amplitude at all speeds, or proportional to "
        "the torque for winding ripple"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "amplitude": Range("torque", 1e-6, 1.0, starts=3, source="0.5 to 3 % of the rated torque"),
            "order": Range("order", 0.5, HIGHEST_ORDER, starts=1),
            "phase": Range("phase", 0.5, 3.1416, starts=1, signed=True),
            **{name: Range("relative", 1e-3, 1.0, starts=2, signed=True) for name in OVERTONE},
        }
    )

    amplitude: float = Field(0.0, ge=0.0, description="[Nm or N], or if proportional, relative to the torque [1]")
    order: float = Field(1.0, gt=0.0, description="periods per turn of the rotor [1]")
    phase: float = Field(0.0, description="phase at motor position zero [rad]")
    second_sine: float = Field(0.0, ge=-1.0, le=1.0, description="sine of twice the order over the amplitude [1]")
    second_cosine: float = Field(0.0, ge=-1.0, le=1.0, description="cosine of twice the order over the amplitude [1]")
    proportional: bool = Field(False, description="whether the ripple is proportional to the torque [-]")

    @model_validator(mode="after")
    def _smaller_than_the_torque(self) -> TorqueRipple:
        if self.proportional and self.amplitude >= 1:
            raise ValueError(
                f"amplitude is {self.amplitude:g}, but a proportional ripple is relative to the torque and must be "
                "below 1; lower it"
            )
        return self

    def turned_round(self) -> TorqueRipple:
        """Return it with another phase, half a period later where the torque that it is proportional to turns too."""
        if not self.proportional:
            return super().turned_round()
        return self.model_copy(update={"phase": np.pi - self.phase, "second_sine": -self.second_sine})

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate the harmonic at the rotor angle."""
        turn = values["order"] * motor.angle + values["phase"]
        sine, cosine = ca.sin(turn), ca.cos(turn)
        overtone = values["second_sine"] * 2 * sine * cosine + values["second_cosine"] * (1 - 2 * sine**2)
        harmonic = values["amplitude"] * (sine + overtone)
        return harmonic * motor.torque if self.proportional else harmonic
