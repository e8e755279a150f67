"""Discrete Fourier transforms of whole periods at chosen lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class PeriodSpectra:
    """Amplitudes of m experiments in steady state, each over P whole periods, at L lines.

    Attributes:
        lines: Multiples of one over the period, increasing, shape (L,).
        period: Samples per period.
        sample_time: T_s [s].
        input: Amplitudes of the inputs, shape (m, P, L, n_u).
        output: Amplitudes of the outputs, shape (m, P, L, n_y).
        reference: Amplitudes of the reference, shape (m, P, L, n_r); None where it is not known.
        block: Block of each experiment, shape (m,).
    """

    lines: IntArray
    period: int
    sample_time: float
    input: ComplexArray
    output: ComplexArray
    reference: ComplexArray | None
    block: IntArray

    @property
    def frequency(self) -> FloatArray:
        """Frequencies of the lines [Hz], shape (L,)."""
        return self.lines / (self.period * self.sample_time)

    @property
    def n_periods(self) -> int:
        """Number P of periods."""
        return int(self.input.shape[1])

    def at(self, lines: IntArray) -> PeriodSpectra:
        """Return the spectra at some of the lines.

        Args:
            lines: Lines that are all in `lines`, shape (K,).
        """
        rows = np.searchsorted(self.lines, lines)
        assert np.array_equal(self.lines[rows], lines)
        reference = None if self.reference is None else self.reference[:, :, rows]
        return PeriodSpectra(
            self.lines[rows],
            self.period,
            self.sample_time,
            self.input[:, :, rows],
            self.output[:, :, rows],
            reference,
            self.block,
        )


def amplitudes(samples: FloatArray, n_periods: int, lines: IntArray) -> ComplexArray:
    """Transform each period: X = 2/N sum x(t_n) exp(-j 2 pi l n / N), n = 0 ... N - 1.

    This is (4.3) of Moberg (2007), scaled so that a cosine of amplitude a gives |X| = a.

    Args:
        samples: Samples of n_periods whole periods of N samples, shape (n_periods N, n).
        n_periods: Number P of periods.
        lines: Multiples of one over the period, shape (L,).

    Returns:
        Amplitudes, shape (P, L, n).

    Raises:
        InputError: The samples are not whole periods, or a line is at or above the Nyquist frequency.
    """
    if n_periods < 1 or len(samples) % n_periods or not len(samples):
        raise InputError(
            f"a record of {len(samples)} samples cannot be {n_periods} whole periods; cut it to whole periods"
        )
    period = len(samples) // n_periods
    check_lines(lines, period)
    spectrum = np.fft.rfft(samples.reshape(n_periods, period, -1), axis=1)[:, lines]
    return np.asarray(2.0 / period * spectrum)


def check_lines(lines: IntArray, period: int) -> None:
    """Reject lines above the Nyquist frequency.

    Args:
        lines: Multiples of one over the period, shape (L,).
        period: Samples per period.

    Raises:
        InputError: A line is negative, or at or above half the number of samples: aliasing.
    """
    if not len(lines):
        raise InputError("no line is excited; give at least one multiple of 1/period")
    if lines.min() < 0 or 2 * lines.max() >= period:
        wrong = int(lines.max() if 2 * lines.max() >= period else lines.min())
        raise InputError(
            f"aliasing: line {wrong} of a period of {period} samples is outside of 0 to {(period - 1) // 2}, so its "
            "frequency is at or above the Nyquist frequency; sample faster or excite lower frequencies"
        )
