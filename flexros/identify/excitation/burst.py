"""Burst: noise or a multisine of limited duration, at rest before and after (Moberg 2007, section 4.1.2)."""

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
from flexros.identify.excitation.multisine import synthesise
from flexros.identify.excitation.record_parts import RecordParts
from flexros.identify.excitation.spectrum import Spectrum, amplitudes
from flexros.identify.excitation.window import window

if TYPE_CHECKING:
    from flexros.arrays import IntArray


class Burst(AbstractExcitation):
    """Band-limited random signal under a window; no leakage if recorded until the robot is at rest.

    With the window h(t) and a sum of cosines with integral p(t), the position is h p and the speed its exact derivative
    h p' + h' p. Phases are new in every block; the motors differ by the phases of the orthogonal matrix T.
    """

    periodic: ClassVar[bool] = False

    kind: Literal["burst"] = Field(description="kind of excitation [name]")
    content: Literal["noise", "multisine"] = Field(
        default="noise",
        description="noise: random amplitudes and phases; multisine: random phases alone [name]",
    )
    duration: float = Field(default=4.0, gt=0.0, le=3600.0, description="length of the burst [s]")
    lowest: float = Field(default=0.5, gt=0.0, description="lower end of the band [Hz]")
    highest: float = Field(default=60.0, gt=0.0, description="upper end of the band [Hz]")
    spectrum: Spectrum = Field(
        default="flat", description="relative amplitudes of the speed: flat, or points [[Hz, 1], ...]"
    )
    taper: float = Field(default=0.25, gt=0.0, description="time to fade in, and to fade out [s]")
    rest_before: float = Field(default=0.2, ge=0.0, description="rest before the burst [s]")
    rest_after: float = Field(default=2.0, ge=0.0, description="rest after it, for the response to die out [s]")

    @model_validator(mode="after")
    def _fits(self) -> Burst:
        if 2.0 * self.taper > self.duration:
            raise ValueError(f"taper is {self.taper:g} s, allowed is at most half the duration of {self.duration:g} s")
        if self.highest < self.lowest:
            raise ValueError(f"highest is {self.highest:g} Hz, allowed is lowest = {self.lowest:g} Hz or more")
        return self

    def record_samples(self, sample_time: float) -> int:
        """Return the samples from rest to rest; see `AbstractExcitation.record_samples`."""
        require_below_nyquist("highest", self.highest, sample_time)
        return self._parts(sample_time).total

    def lines(self, sample_time: float, seed: int) -> Lines:
        """Return all lines of the record within the band; there are no detection lines."""
        del seed
        return Lines.of(self._band(self.record_samples(sample_time) * sample_time))

    def block(self, n_motors: int, sample_time: float, seed: int, position: int, block: int) -> BlockSignals:
        """Compute the records of one block; see `AbstractExcitation.block`."""
        parts = self._parts(sample_time)
        length = parts.length
        lines = self._band(length * sample_time)
        size = amplitudes(self.spectrum, lines / (length * sample_time), self.sizes(n_motors))
        random = phase_generator(seed, position, block)
        phases = random.uniform(0.0, 2.0 * np.pi, (1 if self.orthogonal else n_motors, n_motors, len(lines)))
        if self.content == "noise":
            size = size * random.rayleigh(np.sqrt(0.5), size.shape)
        if self.orthogonal:
            phases = phases + shifts(n_motors).T[:, :, None]
        inside = synthesise(lines, size, phases, length, sample_time)
        height, slope, _ = (part[:, None] for part in window(length, parts.ramp, sample_time))
        shape = (n_motors, parts.total, n_motors)
        speed, moved = np.zeros(shape), np.zeros(shape)
        moved[:, parts.excited] = height * inside.position
        speed[:, parts.excited] = height * inside.speed + slope * inside.position
        return BlockSignals(speed, moved)

    def _parts(self, sample_time: float) -> RecordParts:
        return RecordParts.of(self.rest_before, self.duration, self.rest_after, self.taper, sample_time)

    def _band(self, record: float) -> IntArray:
        """List the lines of a record [s] within the band, shape (F,)."""
        band = f"excitation: the band from {self.lowest:g} to {self.highest:g} Hz"
        return candidate_lines(self.lowest * record, self.highest * record, odd=False, source=band)
