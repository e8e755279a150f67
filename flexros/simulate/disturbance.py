"""Torque disturbances at motors and tool: steps, pulses, chirps and noise (Moberg 2007, Paper C, section 5.2)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from flexros.config.settings import Settings
from flexros.errors import InputError, unknown_name
from flexros.random_streams import Stream, generator
from flexros.simulate.sample_blocks import BLOCK, SampleBlocks, Zeros

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray

WRENCH = ("tool.fx", "tool.fy", "tool.fz", "tool.tx", "tool.ty", "tool.tz")
"""Components of the wrench at the tool in the base frame: forces [N], then torques [Nm]."""


class AbstractDisturbance(Settings, ABC):
    """Disturbance at one location, held between sampling instants like a torque command.

    How to add one: write a final subclass with `kind`, its fields and `values`, and add it to `Disturbance`.
    """

    at: str = Field(description="motor_1, motor_2, ... (torque added to the command [Nm, or N]) or tool.fx ... tool.tz")
    start: float = Field(default=0.0, ge=0.0, description="start time, counted from the start of the run [s]")

    @abstractmethod
    def values(self, index: IntArray, sample_time: float, seed: int, number: int) -> FloatArray:
        """Evaluate at sampling instants.

        Args:
            index: Sample indices, shape (n,).
            sample_time: Time between two samples [s].
            seed: Seed of the run.
            number: Index in the scenario's list, which separates the random streams of disturbances.

        Returns:
            Disturbance in the unit of its location, shape (n,).
        """

    def highest_frequency(self) -> float:
        """Return the highest frequency, which must be below half the sampling rate [Hz]."""
        return 0.0

    def require(self, sample_time: float, source: str) -> None:
        """Check what depends on the sample time.

        Args:
            sample_time: Time between two samples [s].
            source: Origin of the disturbance, e.g. "disturbances[0]".

        Raises:
            InputError: A frequency is above half the sampling rate.
        """
        if self.highest_frequency() * sample_time >= 0.5:
            raise InputError(
                f"{source} reaches {self.highest_frequency():g} Hz, allowed is less than half the "
                f"sampling rate, {0.5 / sample_time:g} Hz; lower the frequency or the sample time"
            )

    def elapsed(self, index: IntArray, sample_time: float) -> FloatArray:
        """Return the time since the first sample at or after `start` [s], shape (n,); negative before it."""
        first = sample_index(self.start, sample_time)
        return np.asarray((index - first) * sample_time, dtype=float)


class Step(AbstractDisturbance):
    """Constant from `start` on."""

    kind: Literal["step"] = Field(description="kind of disturbance [name]")
    amplitude: float = Field(description="height [Nm at a motor; N or Nm at the tool]")

    def values(self, index: IntArray, sample_time: float, seed: int, number: int) -> FloatArray:
        """Evaluate at sampling instants."""
        return np.where(self.elapsed(index, sample_time) >= 0.0, self.amplitude, 0.0)


class Pulse(AbstractDisturbance):
    """Constant from `start` for the duration `width`."""

    kind: Literal["pulse"] = Field(description="kind of disturbance [name]")
    amplitude: float = Field(description="height [Nm at a motor; N or Nm at the tool]")
    width: float = Field(gt=0.0, description="duration, rounded up to whole samples [s]")

    def values(self, index: IntArray, sample_time: float, seed: int, number: int) -> FloatArray:
        """Evaluate at sampling instants."""
        first = sample_index(self.start, sample_time)
        inside = (index >= first) & (index < first + max(sample_index(self.width, sample_time), 1))
        return np.where(inside, self.amplitude, 0.0)


class Chirp(AbstractDisturbance):
    """Sine whose frequency changes linearly from `from_hz` to `to_hz` during `duration`, then zero."""

    kind: Literal["chirp"] = Field(description="kind of disturbance [name]")
    amplitude: float = Field(description="amplitude [Nm at a motor; N or Nm at the tool]")
    from_hz: float = Field(ge=0.0, description="frequency at the start [Hz]")
    to_hz: float = Field(ge=0.0, description="frequency at the end [Hz]")
    duration: float = Field(gt=0.0, description="duration [s]")

    def values(self, index: IntArray, sample_time: float, seed: int, number: int) -> FloatArray:
        """Evaluate at sampling instants."""
        time = self.elapsed(index, sample_time)
        turns = self.from_hz * time + 0.5 * (self.to_hz - self.from_hz) / self.duration * time**2
        sine = self.amplitude * np.sin(2.0 * math.pi * turns)
        return np.where((time >= 0.0) & (time < self.duration), sine, 0.0)

    def highest_frequency(self) -> float:
        """Return the higher end of the sweep [Hz]."""
        return max(self.from_hz, self.to_hz)


class Noise(AbstractDisturbance):
    """Band-limited random noise: equal amplitudes and random phases on all lines of the band, nearly normal."""

    kind: Literal["noise"] = Field(description="kind of disturbance [name]")
    rms: float = Field(ge=0.0, description="root mean square over a period [Nm at a motor; N or Nm at the tool]")
    low_hz: float = Field(default=0.0, ge=0.0, description="lower end of the band [Hz]")
    high_hz: float = Field(gt=0.0, description="upper end of the band [Hz]")
    duration: float | None = Field(default=None, gt=0.0, description="duration [s]; default: to the end of the run")
    period: float = Field(default=60.0, gt=0.0, le=3600.0, description="period [s]")

    @model_validator(mode="after")
    def _band_has_a_width(self) -> Noise:
        if self.high_hz <= self.low_hz:
            raise ValueError(f"high_hz is {self.high_hz:g} Hz, but must be above low_hz = {self.low_hz:g} Hz")
        return self

    def require(self, sample_time: float, source: str) -> None:
        """Check the frequency and that the band holds a line; see `AbstractDisturbance.require`."""
        super().require(sample_time, source)
        samples = self._samples(sample_time)
        first, last = _lines(samples, self.low_hz * sample_time, self.high_hz * sample_time)
        if last < first:
            raise InputError(
                f"{source}: the band from {self.low_hz:g} to {self.high_hz:g} Hz holds no line of the period of "
                f"{samples * sample_time:g} s ({samples} samples), allowed is a band with a multiple of "
                f"{1.0 / (samples * sample_time):.6g} Hz; widen it or lengthen the period"
            )

    def values(self, index: IntArray, sample_time: float, seed: int, number: int) -> FloatArray:
        """Evaluate at sampling instants."""
        time = self.elapsed(index, sample_time)
        samples = self._samples(sample_time)
        table = _noise_table(samples, self.low_hz * sample_time, self.high_hz * sample_time, seed, number)
        first = sample_index(self.start, sample_time)
        end = math.inf if self.duration is None else self.duration
        return np.where((time >= 0.0) & (time < end), self.rms * table[(index - first) % samples], 0.0)

    def highest_frequency(self) -> float:
        """Return the upper end of the band [Hz]."""
        return self.high_hz

    def _samples(self, sample_time: float) -> int:
        """Return the period in samples."""
        return max(sample_index(self.period, sample_time), 2)


Disturbance: TypeAlias = Annotated[Step | Pulse | Chirp | Noise, Field(discriminator="kind")]
"""Any disturbance of a scenario, selected by its key `kind`."""


def sample_index(time: float, sample_time: float) -> int:
    """Return the index of the first sample at or after a time, with a tolerance of a millionth of a sample."""
    return math.ceil(time / sample_time - 1e-6)


def _lines(samples: int, low: float, high: float) -> tuple[int, int]:
    """Return the first and last line of a period between two frequencies, given as fractions of the sampling rate."""
    return max(math.ceil(low * samples - 1e-9), 1), math.floor(high * samples + 1e-9)


@lru_cache(maxsize=16)
def _noise_table(samples: int, low: float, high: float, seed: int, number: int) -> FloatArray:
    """Synthesise one period of unit rms from lines between two frequencies, given as fractions of the sampling rate."""
    first, last = _lines(samples, low, high)
    lines = np.zeros(samples // 2 + 1, dtype=complex)
    phases = generator(seed, Stream.DISTURBANCE, number).uniform(0.0, 2.0 * math.pi, last - first + 1)
    lines[first : last + 1] = np.exp(1j * phases)
    table = np.asarray(np.fft.irfft(lines, samples))
    return table / math.sqrt(float(np.mean(table**2)))


def disturbance_signal(
    disturbances: Sequence[AbstractDisturbance], n_motors: int, sample_time: float, seed: int
) -> SampleBlocks:
    """Sum disturbances by location.

    Args:
        disturbances: Disturbances of a scenario.
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].
        seed: Seed of the run.

    Returns:
        Signal with the columns [motor torque (M), wrench at the tool (6)].

    Raises:
        InputError: Unknown location, a frequency above half the sampling rate, or a band without line.
    """
    width = n_motors + len(WRENCH)
    if not disturbances:
        return Zeros(width)
    columns = [_column(disturbance, number, n_motors) for number, disturbance in enumerate(disturbances)]
    for number, disturbance in enumerate(disturbances):
        disturbance.require(sample_time, f"disturbances[{number}]")

    def make_block(block: int) -> FloatArray:
        index = np.arange(block * BLOCK, (block + 1) * BLOCK)
        signal = np.zeros((BLOCK, width))
        for number, (column, disturbance) in enumerate(zip(columns, disturbances, strict=True)):
            signal[:, column] += disturbance.values(index, sample_time, seed, number)
        return signal

    return SampleBlocks(make_block, width)


def _column(disturbance: AbstractDisturbance, number: int, n_motors: int) -> int:
    locations = (*(f"motor_{motor}" for motor in range(1, n_motors + 1)), *WRENCH)
    if disturbance.at not in locations:
        raise unknown_name("location", disturbance.at, locations, f"disturbances[{number}].at")
    return locations.index(disturbance.at)
