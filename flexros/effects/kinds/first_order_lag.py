"""Lag of first order of a command that is held through an integration step: base class."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.command_law import AbstractCommandLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.motor_law import MotorState
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value

_SHORT, _MANY = 1e-12, 0.02


class AbstractFirstOrderLag(AbstractCommandLaw):
    """A lag T dy/dt = u - y.

    The command u is constant through an integration step, so y is known exactly: u + (y0 - u) exp(-t/T). What follows
    gets the straight line with the same mean and the same first moment over the step, so that speed and position at its
    end have order four. Time constants far below the step need no smaller steps. The own states are that line, y at the
    end of the step, and the slope of the line.

    A member provides `name`, `stage`, `rank` and `locations`.
    """

    size: ClassVar[str] = "time_constant"
    smooth_states = 1
    stepwise_states = 2

    time_constant: float = Field(0.0, ge=0.0, le=1.0, description="time constant T [s]")

    @abstractmethod
    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""

    @property
    def needs_short_steps(self) -> bool:
        """Never: its states are exact in steps of any length."""
        return False

    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the line that approximates the torque in the step."""
        del torque, values
        return own[0]

    def rates(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the slope of the line."""
        del values
        return motor.own[2]

    def before_step(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Advance the torque, and compute the line that approximates it."""
        x = step / ca.fmax(values["time_constant"], _SHORT)
        many = ca.fmax(x, _MANY)
        decay, before = ca.exp(-x), own[1] - torque
        share = ca.if_else(x > _MANY, (1 - decay) / many, 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5))))
        fall = ca.if_else(
            x > _MANY, 12 * ((share - decay) / many - share / 2), -x * (1 - x / 2 * (1 - x * 3 / 10 * (1 - x * 2 / 9)))
        )
        mean, slope = torque + before * share, before * fall / step
        return ca.vertcat(mean - slope * step / 2, torque + before * decay, slope)

    def rest(self, torque: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the steady state, the constant torque itself."""
        del values
        return ca.vertcat(torque, torque, 0)
