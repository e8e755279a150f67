"""Past commands inside an observer, so that its model gets the command that acts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi

from flexros.compile.command_delay import split_delay

if TYPE_CHECKING:
    from flexros.control.context import LoopContext


class CommandLine:
    """The mean command that acts from a sample to the next, behind the delay of the robot.

    Its state are past commands, newest first, M each; a fraction of a sample weighs two of them.

    Args:
        context: The loop.
    """

    def __init__(self, context: LoopContext) -> None:
        self._split = split_delay(context.robot.delay, context.sample_time)
        self._m = context.n_motors

    @property
    def size(self) -> int:
        """Number of states."""
        return int(self._split.line_length * self._m)

    def begun(self, line: casadi.SX, started: casadi.SX, held: casadi.SX) -> casadi.SX:
        """Return the past commands; before the first sample those that held the robot, SX (M, 1)."""
        parts = [casadi.if_else(started, line[row], held[row % self._m]) for row in range(self.size)]
        return casadi.vertcat(casadi.SX(0, 1), *parts)

    def acting(self, line: casadi.SX, command: casadi.SX) -> casadi.SX:
        """Return the mean command that acts after a sample whose command is given, SX (M, 1)."""
        commands, fraction = casadi.vertcat(command, line), self._split.fraction
        first = self._split.whole * self._m
        mean = (1.0 - fraction) * commands[first : first + self._m]
        if fraction > 0.0:
            mean += fraction * commands[first + self._m : first + 2 * self._m]
        return mean

    def after(self, line: casadi.SX, command: casadi.SX) -> casadi.SX:
        """Return the state at the next sample."""
        return casadi.vertcat(command, line)[: self.size] if self.size else casadi.SX(0, 1)
