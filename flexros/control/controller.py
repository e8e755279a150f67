"""A control law at work: compiled, stepped sample by sample."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import casadi
import numpy as np

from flexros.compile.compiled_function import compile_function
from flexros.errors import InputError, RunError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw


class Controller:
    """Steps a control law; a function of measurement, reference and own state, never of a clock.

    Args:
        law: The control law.
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].
        torque_limits: Limits of the robot's motors [Nm], shape (M,); none where left out.

    Raises:
        InputError: The sample time is not positive, or the law does not fit the number of motors.
    """

    def __init__(
        self,
        law: AbstractControlLaw,
        n_motors: int,
        sample_time: float,
        torque_limits: FloatArray | None = None,
    ) -> None:
        if not (math.isfinite(sample_time) and sample_time > 0.0):
            raise InputError(f"sample time of the controller is {sample_time} s, but must be positive; correct it")
        self.law = law
        self.n_motors = n_motors
        self.sample_time = sample_time
        self._gains = law.gains(n_motors, torque_limits)
        self._state = law.initial_state(n_motors)
        self._next_state = np.empty_like(self._state)
        self._reference = np.zeros(3 * n_motors)
        self._position = np.zeros(n_motors)
        self._command = np.zeros(n_motors)
        self._sum = np.zeros(1)
        self._update = compile_function(_with_sum(law.function(n_motors, sample_time))).bind(
            self._state,
            self._reference,
            self._position,
            self._gains,
            self._command,
            self._next_state,
            self._sum,
        )

    def step(self, position: FloatArray | Sequence[float], reference: FloatArray | Sequence[float]) -> FloatArray:
        """Compute the command of one sample and move on.

        Args:
            position: Measured motor positions [rad or m], shape (M,).
            reference: Motor positions (M), velocities (M) and feedforward torques (M), shape (3 M,).

        Returns:
            Torque command [Nm or N], shape (M,).

        Raises:
            RunError: Wrong sizes, or a number that is not finite; the state is as before.
        """
        if len(position) != self.n_motors or len(reference) != 3 * self.n_motors:
            raise RunError(
                f"the controller of {self.n_motors} motors got {len(position)} measured positions and "
                f"{len(reference)} reference values, needed are {self.n_motors} and {3 * self.n_motors}"
            )
        self._position[:] = position
        self._reference[:] = reference
        self._update()
        if not math.isfinite(self._sum[0]):
            raise RunError(self._what_is_not_finite())
        self._state[:] = self._next_state
        command: FloatArray = self._command.copy()
        return command

    def reset(self) -> None:
        """Go back to the state before the first sample."""
        self._state[:] = self.law.initial_state(self.n_motors)

    @property
    def gains(self) -> FloatArray:
        """Gains by the names of `law.gain_names`, shape (n_gains,), a copy."""
        gains: FloatArray = self._gains.copy()
        return gains

    @gains.setter
    def gains(self, gains: FloatArray) -> None:
        """Change the gains, from the next sample on."""
        values = np.asarray(gains, dtype=float)
        if values.shape != self._gains.shape or np.any(np.isnan(values)):
            raise InputError(
                f"gains {values.tolist()} were given, allowed are {len(self._gains)} numbers "
                f"({', '.join(self.law.gain_names(self.n_motors))})"
            )
        self._gains[:] = values

    @property
    def state(self) -> FloatArray:
        """Memory of the law, shape (state_size,), a copy."""
        state: FloatArray = self._state.copy()
        return state

    @state.setter
    def state(self, state: FloatArray) -> None:
        """Restore a memory."""
        self._state[:] = state

    def _what_is_not_finite(self) -> str:
        for name, values in (("measured position", self._position), ("reference", self._reference)):
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                motor = int(bad[0]) % self.n_motors + 1
                return f"the {name} of motor_{motor} is {values[bad[0]]}, needed is a finite number"
        return f"the torque command is {self._command.tolist()}, needed are finite numbers; the loop has diverged"


def _with_sum(law: casadi.Function) -> casadi.Function:
    """Add an output that is finite if and only if inputs and command are: one comparison instead of many."""
    arguments = law.sx_in()
    command, next_state = law(*arguments)
    total = casadi.sum1(arguments[1]) + casadi.sum1(arguments[2]) + casadi.sum1(command)
    return casadi.Function(f"{law.name()}_step", arguments, [command, next_state, total])
