"""Phases of low crest factor for a sum of cosines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, ComplexArray, FloatArray, IntArray

POINTS_PER_CYCLE = 8
"""Smallest number of points per cycle of the highest line at which peaks are searched [1] (chosen)."""

CLIP = (0.7, 0.95)
"""Height at which the signal is clipped, as a share of its peak, in the first and in the last iteration (chosen)."""


def low_crest_phases(
    lines: IntArray, size: FloatArray, phases: FloatArray, iterations: int, envelope: BoolArray
) -> FloatArray:
    """Lower the crest factor by clipping in time and restoring the amplitudes in frequency.

    Swapping between time and frequency domain (Van der Ouderaa, Schoukens and Renneboog 1988): clip the peaks, take the
    phases of the clipped signal, combine them with the desired amplitudes, repeat; the best phases are returned. The
    experiments of an orthogonal set differ by a phase that is the same on all lines. The peaks of all of them are
    bounded by the envelope, the magnitude of the analytic signal, so that the envelope is clipped instead where there
    are several experiments (chosen).

    Args:
        lines: Multiples of one over the period, shape (F,).
        size: Amplitudes, shape (M, F).
        phases: Initial phases [rad], shape (M, F).
        iterations: Number of iterations.
        envelope: Rows whose envelope is clipped instead of the signal, shape (M,).

    Returns:
        Phases [rad], shape (M, F).
    """
    n_points = 1 << int(np.ceil(np.log2(POINTS_PER_CYCLE * int(lines[-1]))))
    shared = envelope[:, None]
    best, best_peak = phases, np.full(len(phases), np.inf)
    for iteration in range(iterations + 1):
        signal = _signal(lines, size, phases, n_points)
        height = np.where(shared, np.abs(signal), np.abs(signal.real))
        peak = np.max(height, axis=1)
        better = peak < best_peak
        best = np.where(better[:, None], phases, best)
        best_peak = np.where(better, peak, best_peak)
        level = (CLIP[0] + (CLIP[1] - CLIP[0]) * iteration / max(iterations, 1)) * peak[:, None]
        over = np.maximum(height / np.where(level > 0.0, level, 1.0), 1.0)
        clipped = np.where(shared, signal, signal.real) / over
        phases = np.angle(np.fft.fft(clipped, axis=1)[:, lines])
    return best


def _signal(lines: IntArray, size: FloatArray, phases: FloatArray, n_points: int) -> ComplexArray:
    """Evaluate the analytic signal over a period, shape (M, n_points)."""
    spectrum = np.zeros((len(size), n_points), dtype=complex)
    spectrum[:, lines] = n_points * size * np.exp(1j * phases)
    result: ComplexArray = np.fft.ifft(spectrum, axis=1)
    return result
