"""Swept sine from rest to rest (Moberg 2007, section 4.1.3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from flexros.identify.excitation.base import (
    AbstractExcitation,
    BlockSignals,
    phase_generator,
    require_below_nyquist,
    shifts,
)
from flexros.identify.excitation.lines import Lines, candidate_lines
from flexros.identify.excitation.record_parts import RecordParts
from flexros.identify.excitation.window import window

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class Chirp(AbstractExcitation):
    """Sine whose frequency sweeps from one end of the band to the other, at rest before and after.

    With the angle phi(t), its rate w(t) and the window h(t), the position is p = -h A cos(phi) / w and the speed its
    exact derivative,

        v = h A sin(phi) + h A (w' / w^2) cos(phi) - h' A cos(phi) / w,

    which is the swept sine apart from two small terms, so that the robot ends where it began (chosen; the thesis gives
    only the two frequencies and the speed reference). The motors of a robot differ by the phases of the orthogonal
    matrix T.
    """

    periodic: ClassVar[bool] = False

    kind: Literal["chirp"] = Field(description="kind of excitation [name]")
    duration: float = Field(default=20.0, gt=0.0, le=3600.0, description="length of the sweep [s]")
    from_hz: float = Field(default=50.0, gt=0.0, description="frequency at the start [Hz]")
    to_hz: float = Field(default=1.0, gt=0.0, description="frequency at the end [Hz]")
    sweep: Literal["linear", "logarithmic"] = Field(
        default="linear", description="whether the frequency changes equally per second, or by an equal factor [name]"
    )
    taper: float = Field(default=0.5, gt=0.0, description="time to fade in, and to fade out [s]")
    rest_before: float = Field(default=0.5, ge=0.0, description="rest before the sweep [s]")
    rest_after: float = Field(default=2.0, ge=0.0, description="rest after it, for the response to die out [s]")

    @model_validator(mode="after")
    def _taper_fits(self) -> Chirp:
        if 2.0 * self.taper > self.duration:
            raise ValueError(f"taper is {self.taper:g} s, allowed is at most half the duration of {self.duration:g} s")
        return self

    def record_samples(self, sample_time: float) -> int:
        """Return the samples from rest to rest; see `AbstractExcitation.record_samples`."""
        require_below_nyquist("from_hz", self.from_hz, sample_time)
        require_below_nyquist("to_hz", self.to_hz, sample_time)
        return self._parts(sample_time).total

    def lines(self, sample_time: float, seed: int) -> Lines:
        """Return all lines that the sweep passes; there are no detection lines."""
        del seed
        record = self.record_samples(sample_time) * sample_time
        low, high = sorted((self.from_hz, self.to_hz))
        band = f"excitation: the band from {low:g} to {high:g} Hz"
        return Lines.of(candidate_lines(low * record, high * record, odd=False, source=band))

    def block(self, n_motors: int, sample_time: float, seed: int, position: int, block: int) -> BlockSignals:
        """Compute the records of one block, the same in all blocks unless `orthogonal` is false."""
        size = self.sizes(n_motors)
        start = shifts(n_motors).T
        if not self.orthogonal:
            start = phase_generator(seed, position, block).uniform(0.0, 2.0 * np.pi, (n_motors, n_motors))
        parts = self._parts(sample_time)
        angle, rate, change = self._sweep(np.arange(parts.length, dtype=np.float64) * sample_time)
        height, slope, _ = window(parts.length, parts.ramp, sample_time)
        phi = angle[None, :, None] + start[:, None, :]
        height, slope, rate, change = (part[None, :, None] for part in (height, slope, rate, change))
        shape = (n_motors, parts.total, n_motors)
        speed, moved = np.zeros(shape), np.zeros(shape)
        rows = parts.excited
        moved[:, rows] = -size * height * np.cos(phi) / rate
        speed[:, rows] = size * (height * (np.sin(phi) + change / rate**2 * np.cos(phi)) - slope * np.cos(phi) / rate)
        return BlockSignals(speed, moved)

    def _parts(self, sample_time: float) -> RecordParts:
        return RecordParts.of(self.rest_before, self.duration, self.rest_after, self.taper, sample_time)

    def _sweep(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return angle [rad], its rate [rad/s] and its derivative [rad/s^2] at times in the sweep, each (n,)."""
        first, last = 2.0 * np.pi * self.from_hz, 2.0 * np.pi * self.to_hz
        if self.sweep == "linear" or first == last:
            change = (last - first) / self.duration
            return first * t + 0.5 * change * t**2, first + change * t, np.full(t.shape, change)
        growth = np.log(last / first) / self.duration
        rate = first * np.exp(growth * t)
        return (rate - first) / growth, rate, growth * rate
