"""Delay and rate of further sensors: which earlier sample a value that is held at a sample comes from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.robot.further_sensors import FurtherSensor

_WHOLE = 1e-6
"""Largest deviation of a delay or period from whole samples [samples] that counts as round-off."""


@dataclass(frozen=True)
class SensorTiming:
    """Delay and period of every channel in samples, shape (n_further,) each.

    At sample k a channel holds the value of sample max(k - k mod period - delay, 0).

    Attributes:
        delay: Age of a value when it is sent [samples].
        period: Samples from one value to the next [samples].
    """

    delay: tuple[int, ...]
    period: tuple[int, ...]

    @classmethod
    def of(cls, sensors: Sequence[FurtherSensor], sample_time: float) -> SensorTiming:
        """Express delay and rate of sensors in samples of a loop.

        Raises:
            InputError: A delay or a period is not a whole number of samples; names the sensor.
        """
        delay: list[int] = []
        period: list[int] = []
        for sensor in sensors:
            key = {"link_states": "sensors.link", "tool_imu": "sensors.tool_imu"}[sensor.topic]
            late = _whole(sensor.delay / sample_time, f"{key}.delay is {sensor.delay:g} s", 0, sample_time)
            given = f"{key}.rate is {sensor.rate} Hz"
            every = 1 if sensor.rate is None else _whole(1.0 / (sensor.rate * sample_time), given, 1, sample_time)
            delay += [late] * sensor.size
            period += [every] * sensor.size
        return cls(tuple(delay), tuple(period))

    @property
    def size(self) -> int:
        """Number of channels."""
        return len(self.delay)

    @property
    def is_immediate(self) -> bool:
        """Whether every channel shows its value at every sample."""
        return not any(self.delay) and all(period == 1 for period in self.period)

    @property
    def longest(self) -> int:
        """Largest age of a held value [samples]."""
        return max((delay + period - 1 for delay, period in zip(self.delay, self.period)), default=0)

    def held_rows(self, samples: IntArray) -> IntArray:
        """Return the sample from which the value held at each sample comes, shape (n, n_further)."""
        k = samples[:, np.newaxis]
        rows: IntArray = np.maximum(k - k % np.array(self.period, int) - np.array(self.delay, int), 0)
        return rows

    def held(self, values: FloatArray) -> FloatArray:
        """Return the values that are held at each sample of a whole run, shape (n, n_further), from those measured."""
        if self.is_immediate:
            return values
        return np.take_along_axis(values, self.held_rows(np.arange(len(values))), axis=0)

    @cached_property
    def memory_size(self) -> int:
        """Number of states of `behind`."""
        return 0 if self.is_immediate else 1 + 2 * self.size + sum(self.delay)

    def behind(self, controller: ca.Function, n_motors: int) -> ca.Function:
        """Place delay and hold between the sensors and a controller (c, r, y, g) -> (u, c_next).

        The memory follows the state of the controller, and starts from zeros: [samples so far, held values, samples
        until the next value, delay lines].

        Args:
            controller: The controller.
            n_motors: Number of motors, whose encoder values are passed at once.
        """
        if self.is_immediate:
            return controller
        c, r, y, g = controller.sx_in()
        memory = ca.SX.sym("memory", self.memory_size)
        started, values = memory[0] > 0.5, y[n_motors:]
        n = self.size
        held, wait, line = memory[1 : 1 + n], memory[1 + n : 1 + 2 * n], memory[1 + 2 * n :]
        seen, waits, lines, begin = [], [], [], 0
        for channel in range(n):
            end = begin + self.delay[channel]
            past = [ca.if_else(started, line[row], values[channel]) for row in range(begin, end)]
            begin = end
            aged = [values[channel], *past]  # newest first
            fresh = wait[channel] < 0.5
            seen.append(ca.if_else(fresh, aged[-1], held[channel]))
            waits.append(ca.if_else(fresh, self.period[channel] - 1.0, wait[channel] - 1.0))
            lines += aged[:-1]
        u, c_next = controller(c, r, ca.vertcat(y[:n_motors], *seen), g)
        after = ca.vertcat(c_next, 1.0, *seen, *waits, *lines)
        state = ca.SX.sym("c", c.numel() + memory.numel())
        u, after = ca.substitute([u, after], [c, memory], [state[: c.numel()], state[c.numel() :]])
        return ca.Function(controller.name(), [state, r, y, g], [ca.densify(u), ca.densify(after)])


class SensorMemory:
    """Values of further sensors as they are held, sample by sample; bit-equal to `SensorTiming.held`.

    Args:
        timing: Delay and period of every channel.
    """

    def __init__(self, timing: SensorTiming) -> None:
        self._timing = timing
        self._past: list[FloatArray] = []
        self._held = np.zeros(timing.size)

    def add(self, sample: int, values: FloatArray) -> FloatArray:
        """Take the values measured at a sample, samples in order, and return those held at it, shape (n_further,)."""
        timing = self._timing
        if timing.is_immediate:
            return values.copy()
        self._past.insert(0, values.copy())
        del self._past[timing.longest + 1 :]
        rows = timing.held_rows(np.array([sample]))[0]
        self._held = np.array([self._past[min(sample - row, len(self._past) - 1)][i] for i, row in enumerate(rows)])
        return self._held.copy()


def _whole(samples: float, given: str, least: int, sample_time: float) -> int:
    whole = round(samples)
    if abs(samples - whole) > _WHOLE * max(1.0, samples) or whole < least:
        raise InputError(
            f"{given}, which are {samples:.6g} samples of {sample_time:g} s, but must be a whole number from {least} on"
        )
    return whole
