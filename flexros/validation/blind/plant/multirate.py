"""Controller, encoder and delays of a blind plant at the fine rate of its integration.

The closed loop of a blind plant runs with many ticks per sample. At the first tick of a sample the encoder is read, at
its own instant, and the controller computes; at every tick each motor gets the mean of the commands that are due within
it, so that commands arrive at exact times whatever their delay.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence


@dataclass(frozen=True, eq=False)
class MultirateLoop:
    """Parts of the controller at the fine rate.

    Attributes:
        law: Update (c, r, y, g) -> (u, c_next) of the controller.
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].
        ticks: Integration steps per sample.
        remembered: Number of past commands that may still arrive.
        delays: Delay of each motor's command [s], length M, of the numbers `numbers`.
        readings: What each encoder makes of its position, by motor.
        numbers: Symbols of the numbers of all deviations, SX (P, 1).
        q: Coordinates that the readings depend on.
        places: Place of each motor among the coordinates.
    """

    law: ca.Function
    n_motors: int
    sample_time: float
    ticks: int
    remembered: int
    delays: Sequence[ca.SX]
    readings: Mapping[int, Sequence[Callable[[ca.SX], ca.SX]]]
    numbers: ca.SX
    q: ca.SX
    places: Sequence[int]

    @property
    def width(self) -> int:
        """Number of outputs: arriving torque, encoder value and command of each motor, and the push."""
        return 3 * self.n_motors + 1

    @property
    def n_states(self) -> int:
        """Number of states: tick, those of the law, past commands with the newest first, encoder values."""
        return 1 + int(self.law.numel_in(0)) + (self.remembered + 2) * self.n_motors

    def function(self) -> ca.Function:
        """Build (c, r, y, g) -> (u, c_next) at the fine rate.

        r is [reference (3 M), encoder noise (M), lateness of the reading (M), loss (1), push (1)], y is [motor
        positions (M), speeds (M), unused (M + 1)], g is [gains of the law, numbers of the deviations].
        """
        m, n_law = self.n_motors, int(self.law.numel_in(0))
        c, r, y = ca.SX.sym("c", self.n_states), ca.SX.sym("r", 5 * m + 2), ca.SX.sym("y", self.width)
        gains = ca.SX.sym("gains", self.law.numel_in(3))
        tick, state, line, seen = ca.vertsplit(c, [0, 1, 1 + n_law, self.n_states - m, self.n_states])
        first = tick < 0.5
        reading = self._reading(y[:m], y[m : 2 * m], r[3 * m : 4 * m], r[4 * m : 5 * m])
        command, after = self.law(state, r[: 3 * m], reading, gains)
        newest = ca.if_else(r[5 * m] > 0.5, line[:m], command)  # a lost command leaves the one before
        moved = ca.vertcat(newest, line[:-m])
        line = _choose(first, moved, line)
        seen = _choose(first, reading, seen)
        given = _choose(first, command, seen * 0)
        end = ca.if_else(tick > self.ticks - 1.5, 0, tick + 1)
        memory = ca.vertcat(end, _choose(first, after, state), line, seen)
        out = ca.vertcat(self._arriving(line, tick), seen, given, r[5 * m + 1])
        return ca.Function("multirate", [c, r, y, ca.vertcat(gains, self.numbers)], [out, memory], {"cse": True})

    def _reading(self, position: ca.SX, speed: ca.SX, noise: ca.SX, late: ca.SX) -> ca.SX:
        seen = []
        for motor in range(self.n_motors):
            value = position[motor] + late[motor] * speed[motor] + noise[motor]
            for reading in self.readings.get(motor, ()):
                value = ca.substitute(reading(value), self.q[self.places[motor]], position[motor])
            seen.append(value)
        return ca.vertcat(*seen)

    def _arriving(self, line: ca.SX, tick: ca.SX) -> ca.SX:
        """Average the commands that are due within a tick."""
        T, h = self.sample_time, self.sample_time / self.ticks
        torque = []
        for motor in range(self.n_motors):
            total = ca.SX(0)
            for age in range(self.remembered + 1):
                begin = self.delays[motor] - age * T
                inside = ca.fmin((tick + 1) * h, begin + T) - ca.fmax(tick * h, begin)
                total += ca.fmax(inside, 0) / h * line[age * self.n_motors + motor]
            torque.append(total)
        return ca.vertcat(*torque)


def _choose(condition: ca.SX, yes: ca.SX, no: ca.SX) -> ca.SX:
    return ca.vertcat(*[ca.if_else(condition, yes[k], no[k]) for k in range(yes.numel())])
