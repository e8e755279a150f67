"""Orthogonal random-phase multisine (Moberg 2007, Paper A, equation 3; Dobrowiecki and Schoukens 2007)."""

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
    whole_samples,
)
from flexros.identify.excitation.crest_factor import low_crest_phases
from flexros.identify.excitation.lines import Lines, candidate_lines, spread, with_detection
from flexros.identify.excitation.spectrum import Spectrum, amplitudes

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

LINES_STREAM = 0
"""Index of the random stream of the detection lines."""

PHASES_STREAM = 1
"""Index of the random streams of the phases, followed by position and block."""


class Multisine(AbstractExcitation):
    """Sum of cosines of the speed on lines of the period, with random phases that are new in every block.

    Motor i has in experiment l of a block

        r_il(t) = sum_k A_ik cos(w_k t + phi_ik + 2 pi (i-1)(l-1) / n),

    so that the spectra of the n experiments are R = R_diag T with the orthogonal matrix T: U U^H is diagonal at every
    line, which is optimal for n experiments of this size (Paper A, section 4).
    """

    periodic: ClassVar[bool] = True

    kind: Literal["multisine"] = Field(default="multisine", description="kind of excitation [name]")
    period: float = Field(default=2.0, gt=0.0, le=600.0, description="period, one over the distance of the lines [s]")
    lowest: float = Field(default=1.0, gt=0.0, description="lower end of the band [Hz]")
    highest: float = Field(default=60.0, gt=0.0, description="upper end of the band [Hz]")
    grid: Literal["linear", "logarithmic"] = Field(
        default="linear", description="spacing of the excited lines in the band [name]"
    )
    number: int | None = Field(
        default=None, ge=2, description="number of lines before detection lines are removed; default: all [1]"
    )
    lines_of: Literal["odd", "all"] = Field(
        default="odd", description="odd: even lines stay empty and show even distortions; all: any line [name]"
    )
    detection_group: int | None = Field(
        default=4,
        ge=2,
        description="of every such number of neighbouring lines one, chosen at random, stays empty and shows odd "
        "distortions; null: none [1]",
    )
    spectrum: Spectrum = Field(
        default="flat", description="relative amplitudes of the speed: flat, or points [[Hz, 1], ...]"
    )
    crest_iterations: int = Field(
        default=200, ge=0, le=100_000, description="iterations that lower the crest factor; 0: phases stay random [1]"
    )

    @model_validator(mode="after")
    def _band_has_a_width(self) -> Multisine:
        if self.highest < self.lowest:
            raise ValueError(f"highest is {self.highest:g} Hz, allowed is lowest = {self.lowest:g} Hz or more")
        return self

    def record_samples(self, sample_time: float) -> int:
        """Return the period [samples]; see `AbstractExcitation.record_samples`."""
        require_below_nyquist("highest", self.highest, sample_time)
        return whole_samples("period", self.period, sample_time)

    def lines(self, sample_time: float, seed: int) -> Lines:
        """Choose the lines; see `AbstractExcitation.lines`."""
        period = self.record_samples(sample_time) * sample_time
        band = f"excitation: the band from {self.lowest:g} to {self.highest:g} Hz"
        lines = candidate_lines(self.lowest * period, self.highest * period, self.lines_of == "odd", band)
        lines = spread(lines, self.number, self.grid == "logarithmic")
        if self.detection_group is not None:
            lines = with_detection(lines, self.detection_group, phase_generator(seed, LINES_STREAM))
        return Lines.of(lines)

    def block(self, n_motors: int, sample_time: float, seed: int, position: int, block: int) -> BlockSignals:
        """Compute the periods of one block; see `AbstractExcitation.block`."""
        n_samples, lines = self.record_samples(sample_time), self.lines(sample_time, seed).excited
        size = amplitudes(self.spectrum, lines / (n_samples * sample_time), self.sizes(n_motors))
        random = phase_generator(seed, PHASES_STREAM, position, block)
        n_sets = 1 if self.orthogonal else n_motors
        phases = random.uniform(0.0, 2.0 * np.pi, (n_sets, n_motors, len(lines)))
        shifted = self.orthogonal & np.any(np.sin(shifts(n_motors)) ** 2 > 1e-9, axis=1)  # else only the sign changes
        phases = np.array([low_crest_phases(lines, size, p, self.crest_iterations, shifted) for p in phases])
        if self.orthogonal:
            phases = phases + shifts(n_motors).T[:, :, None]
        return synthesise(lines, size, phases, n_samples, sample_time)


def synthesise(
    lines: IntArray, size: FloatArray, phases: FloatArray, n_samples: int, sample_time: float
) -> BlockSignals:
    """Evaluate sums of cosines and their integrals of zero mean over one period.

    Args:
        lines: Multiples of one over the period, below half the number of samples, shape (F,).
        size: Amplitudes of the speed, shape (M, F).
        phases: Phases [rad], shape (n_experiments, M, F).
        n_samples: Samples of the period.
        sample_time: Time between two samples [s].

    Returns:
        The signals, shape (n_experiments, n_samples, M).
    """
    spectrum = np.zeros((*phases.shape[:2], n_samples // 2 + 1), dtype=complex)
    spectrum[..., lines] = 0.5 * n_samples * size * np.exp(1j * phases)
    speed = np.fft.irfft(spectrum, n_samples, axis=-1)
    spectrum[..., lines] /= 2j * np.pi * lines / (n_samples * sample_time)
    position = np.fft.irfft(spectrum, n_samples, axis=-1)
    return BlockSignals(np.ascontiguousarray(speed.swapaxes(1, 2)), np.ascontiguousarray(position.swapaxes(1, 2)))
