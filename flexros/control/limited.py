"""Base of control laws with gains per motor and a limited command."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import casadi
import numpy as np
from pydantic import Field

from flexros.config.per_motor import NotNegativePerMotor, PositivePerMotor, per_motor
from flexros.control.base import AbstractControlLaw

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.robot import Robot


Gain: TypeAlias = NotNegativePerMotor
"""A gain, one for all motors or one per motor."""


class AbstractLimitedLaw(AbstractControlLaw):
    """A law with gains per motor, `gain_keys`, and a torque limit; its base decides what the update looks like."""

    gain_keys: ClassVar[tuple[str, ...]]
    lowest_gain: ClassVar[float] = 0.0

    torque_limit: PositivePerMotor | None = Field(
        default=None, description="limit of the command [Nm], one or one per motor; default: the limits of the robot"
    )

    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        """Return the names of `gain_keys`, then torque_limit, each for all motors, e.g. "motor_1.kp", then others."""
        keys = (*self.gain_keys, "torque_limit")
        own = tuple(f"motor_{motor}.{key}" for key in keys for motor in range(1, context.n_motors + 1))
        return (*own, *self.further_gains(context))

    def gains(self, context: LoopContext) -> FloatArray:
        """Return the gain vector; the torque limit is the lower of the setting and the robot's."""
        gains = (per_motor(f"controller.{key}", getattr(self, key), context.n_motors) for key in self.gain_keys)
        further = np.array([*self.further_gains(context).values()], dtype=float)
        return np.concatenate([*gains, self.command_limits(context.robot), further])

    def further_gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return further gains that are not per motor, by name, e.g. those of an observer."""
        del context
        return {}

    def command_limits(self, robot: Robot) -> FloatArray:
        """Return the lower of the controller's and the robot's torque limit [Nm or N], shape (M,)."""
        if self.torque_limit is None:
            return robot.torque_limits
        return np.minimum(robot.torque_limits, per_motor("controller.torque_limit", self.torque_limit, robot.n_motors))


@dataclass(frozen=True, eq=False)
class LoopSignals:
    """References and measurements of one sample, by name.

    Attributes:
        context: Their layout.
        r: All references, SX (context.references.size, 1).
        y: All measurements, SX (context.measurements.size, 1).
    """

    context: LoopContext
    r: casadi.SX
    y: casadi.SX

    def reference(self, name: str) -> casadi.SX:
        """Return a reference, e.g. "motor_position", SX (M, 1)."""
        return self.context.references.part(self.r, name)

    def measured(self, name: str) -> casadi.SX:
        """Return a measurement, e.g. "link_position", SX (its size, 1)."""
        return self.context.measurements.part(self.y, name)


class AbstractSignalLaw(AbstractLimitedLaw):
    """A limited law on any references and measurements.

    How to add one: list the fields that are gains in `gain_keys` and write `state_size` and `control`.
    """

    @abstractmethod
    def control(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[casadi.SX, Callable[[casadi.SX], casadi.SX]]:
        """Compute one sample.

        Args:
            state: State of the law, SX (state_size, 1).
            signals: References and measurements.
            gains: Gains by the names of `gain_keys`, SX (M, 1), and of `further_gains`, SX scalars.

        Returns:
            Command before its limit, SX (M, 1), and the next state as a function of the command after it.
        """

    def function(self, context: LoopContext) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function."""
        state = casadi.SX.sym("c", self.state_size(context))
        reference = casadi.SX.sym("r", context.references.size)
        measured = casadi.SX.sym("y", context.measurements.size)
        names = self.gain_names(context)
        vector, m, keys = casadi.SX.sym("g", len(names)), context.n_motors, (*self.gain_keys, "torque_limit")
        gains = {key: vector[m * place : m * (place + 1)] for place, key in enumerate(keys)}
        gains |= {name: vector[place] for place, name in enumerate(names) if place >= m * len(keys)}
        wanted, next_state = self.control(state, LoopSignals(context, reference, measured), gains)
        limit = gains["torque_limit"]
        command = casadi.fmax(-limit, casadi.fmin(limit, wanted))
        return casadi.Function(
            self.kind,
            [state, reference, measured, vector],
            [casadi.densify(command), casadi.densify(next_state(command))],
            ["c", "r", "y", "g"],
            ["u", "c_next"],
            {"cse": True},
        )
