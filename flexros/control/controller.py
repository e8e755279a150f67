"""A control law at run time: compiled and stepped sample by sample."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import casadi
import numpy as np

from flexros.compile.compiled_function import compile_function
from flexros.errors import InputError, RunError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.context import LoopContext, SignalLayout


class Controller:
    """Steps a control law as a function of measurement, reference and its own state; it reads no clock.

    Args:
        law: The control law.
        context: Robot, sample time and signals of the loop.

    Raises:
        InputError: The law does not fit the robot.
    """

    def __init__(self, law: AbstractControlLaw, context: LoopContext) -> None:
        self.law = law
        self.context = context
        self._gains = law.gains(context)
        self._state = law.initial_state(context)
        self._next_state = np.empty_like(self._state)
        self._reference = np.zeros(context.references.size)
        self._measured = np.zeros(context.measurements.size)
        self._command = np.zeros(context.n_motors)
        self._sum = np.zeros(1)
        self._function = law.function(context)
        self._update = compile_function(_with_sum(self._function)).bind(
            self._state,
            self._reference,
            self._measured,
            self._gains,
            self._command,
            self._next_state,
            self._sum,
        )

    def step(self, measured: FloatArray | Sequence[float], reference: FloatArray | Sequence[float]) -> FloatArray:
        """Compute the command of one sample and update the state.

        Args:
            measured: Measurements in the order of `context.measurements`, shape (its size,).
            reference: References in the order of `context.references`, shape (its size,).

        Returns:
            Torque command [Nm or N], shape (M,).

        Raises:
            RunError: Wrong sizes, or a value that is not finite; the state is unchanged.
        """
        if len(measured) != len(self._measured) or len(reference) != len(self._reference):
            raise RunError(
                f"the controller of {self.context.n_motors} motors got {len(measured)} measurements and "
                f"{len(reference)} reference values, needed are {len(self._measured)} and {len(self._reference)}"
            )
        self._measured[:] = measured
        self._reference[:] = reference
        self._update()
        if not math.isfinite(self._sum[0]):
            raise RunError(self._not_finite())
        self._state[:] = self._next_state
        command: FloatArray = self._command.copy()
        return command

    def reset(self) -> None:
        """Restore the state before the first sample."""
        self._state[:] = self.law.initial_state(self.context)

    @cached_property
    def uses_further(self) -> bool:
        """Whether the command or the next state depends on sensors beside the motor encoders."""
        arguments = self._function.sx_in()
        further = arguments[2][self.context.n_motors :]
        outputs = casadi.vertcat(*self._function(*arguments))
        return bool(further.numel()) and any(casadi.which_depends(outputs, further, 1, False))

    @property
    def gain_names(self) -> tuple[str, ...]:
        """Names of the gains."""
        return self.law.gain_names(self.context)

    @property
    def gains(self) -> FloatArray:
        """Copy of the gains in the order of `law.gain_names`, shape (n_gains,)."""
        gains: FloatArray = self._gains.copy()
        return gains

    @gains.setter
    def gains(self, gains: FloatArray) -> None:
        """Set the gains, from the next sample on."""
        values = np.asarray(gains, dtype=float)
        if values.shape != self._gains.shape or np.any(np.isnan(values)):
            raise InputError(
                f"gains {values.tolist()} were given, allowed are {len(self._gains)} numbers "
                f"({', '.join(self.gain_names)})"
            )
        self._gains[:] = values

    @property
    def state(self) -> FloatArray:
        """Copy of the state of the law, shape (state_size,)."""
        state: FloatArray = self._state.copy()
        return state

    @state.setter
    def state(self, state: FloatArray) -> None:
        """Set the state of the law."""
        self._state[:] = state

    def _not_finite(self) -> str:
        """Name the first value that is not finite."""
        context = self.context
        for kind, values, layout in (
            ("measured", self._measured, context.measurements),
            ("reference", self._reference, context.references),
        ):
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                return f"the {kind} {self._element(layout, int(bad[0]))} is {values[bad[0]]}, needed is a finite number"
        return f"the torque command is {self._command.tolist()}, needed are finite numbers; the loop has diverged"

    def _element(self, layout: SignalLayout, row: int) -> str:
        name, index = layout.element(row)
        per_motor = layout.sizes[name] == self.context.n_motors
        return f"{name} of {self.context.robot.joint_names[index]}" if per_motor else f"{name}[{index}]"


def _with_sum(law: casadi.Function) -> casadi.Function:
    """Append an output that is finite if and only if inputs and command are: one comparison instead of many."""
    arguments = law.sx_in()
    command, next_state = law(*arguments)
    total = casadi.sum1(arguments[1]) + casadi.sum1(arguments[2]) + casadi.sum1(command)
    return casadi.Function(f"{law.name()}_step", arguments, [command, next_state, total])
