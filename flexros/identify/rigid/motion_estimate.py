"""Speeds and accelerations from measured positions, and the common low-pass of all signals of the regression."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import butter, firwin, sosfiltfilt
from scipy.sparse import csr_array

from flexros.errors import InputError
from flexros.record.even_grid import HIGHEST_RATE
from flexros.record.smoothing import noise_power

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray

_ORDER = 4
"""Order of the Butterworth filter, applied forwards and backwards (as by the authors of EMPS)."""

HIGHEST_CUTOFF = 0.25
"""Largest corner of that filter over the sampling rate [1] (chosen)."""

_LENGTH = 20
"""Length of the low-pass before decimation, in decimated samples (usual for a finite response)."""

_WINDOWS = 2
"""Such lengths that a log must have (chosen)."""

_PASS = 0.9
"""Its corner, relative to half the decimated rate (chosen)."""

_STILL = 20.0
"""Range of a position, in rms values of its noise, up to which a motor is at rest (chosen)."""

_ODD_RATE = ", or correct the time unit in the mapping if the rate is not that of the recorder"

_FEWEST = 50
"""Fewest rows after decimation (chosen)."""


@dataclass(frozen=True, eq=False)
class MotionEstimate:
    """Motion by zero-phase filtering.

    Attributes:
        position: Filtered positions [rad or m], shape (n, M).
        velocity: Speeds, shape (n, M); zero for a motor at rest.
        acceleration: Accelerations, shape (n, M); zero for a motor at rest.
        moving: Which motors moved, shape (M,).
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    moving: BoolArray


def estimate_motion(position: FloatArray, sample_time: float, cutoff: float) -> MotionEstimate:
    """Apply a zero-phase filter to positions and take central differences (thesis 4.2.1: speeds have to be estimated).

    A motor whose filtered position varies no more than its noise is at rest: its speed would be noise, and noise in the
    regressor biases parameters towards zero.

    Args:
        position: Measured positions [rad or m], shape (n, M).
        sample_time: Interval [s].
        cutoff: Corner frequency of the Butterworth filter [Hz].

    Returns:
        The motion.

    Raises:
        InputError: The corner is too high for the sampling rate, or the record too short.
    """
    rate = 1 / sample_time
    if not 0 < cutoff <= HIGHEST_CUTOFF * rate:
        raise InputError(
            f"the cut-off is {cutoff:.6g} Hz, but must be above 0 and at most a quarter of the sampling rate of "
            f"{rate:.6g} Hz",
            "cutoff",
        )
    least = _WINDOWS * decimation(sample_time, cutoff) * _LENGTH
    if len(position) < least:
        raise InputError(
            f"the log has {len(position)} samples, but a cut-off of {cutoff:.6g} Hz needs at least {least} at "
            f"{_in_words(rate)}; give a longer log or a higher cut-off{_ODD_RATE if rate > HIGHEST_RATE else ''}"
        )
    sections = butter(_ORDER, 2 * cutoff * sample_time, output="sos")
    filtered: FloatArray = sosfiltfilt(sections, position, axis=0)
    noise = np.minimum(np.sqrt(np.mean((position - filtered) ** 2, axis=0)), _noise(position))
    moving: BoolArray = np.ptp(filtered, axis=0) > _STILL * noise
    velocity = np.gradient(filtered, sample_time, axis=0)
    acceleration = np.zeros_like(filtered)
    acceleration[1:-1] = np.diff(filtered, 2, axis=0) / sample_time**2
    return MotionEstimate(
        np.where(moving, filtered, filtered.mean(axis=0)), velocity * moving, acceleration * moving, moving
    )


def _noise(position: FloatArray) -> FloatArray:
    """Return the noise of positions and their rounding where they move least [rad or m], shape (M,).

    What the filter removes may be motion that is faster than its corner.
    """
    change = np.abs(np.diff(position, axis=0))
    step = np.min(change, axis=0, where=change > 0, initial=np.inf) / np.sqrt(12)
    return np.asarray(np.maximum(np.sqrt(noise_power(position)), np.where(np.isfinite(step), step, 0.0)))


def lowest_cutoff(samples: int, sample_time: float) -> float:
    """Return the lowest corner of `estimate_motion` that a log is long enough for [Hz].

    Args:
        samples: Length of the log.
        sample_time: Interval [s].
    """
    return 1 / (sample_time * max(1, samples // (_WINDOWS * _LENGTH)))


def _in_words(rate: float) -> str:
    """Format a sampling rate [Hz] in Hz, kHz or MHz."""
    size, unit = next((pair for pair in ((1e6, "MHz"), (1e3, "kHz")) if rate >= pair[0]), (1.0, "Hz"))
    return f"{rate / size:.6g} {unit}"


def decimation(sample_time: float, cutoff: float) -> int:
    """Return the decimation factor that leaves one sample per period of the cut-off [Hz]."""
    return max(1, round(1 / (sample_time * cutoff)))


def decimate(values: FloatArray, factor: int) -> FloatArray:
    """Apply a zero-phase low-pass and decimate; rows that depend on the ends of the record are left out.

    Torque and every column of the regressor pass the same filter, which therefore changes no parameter (M. Gautier,
    1997, parallel filtering).

    Args:
        values: Shape (n, ...).
        factor: Decimation factor.

    Returns:
        Shape (m, ...), the first row at sample `edge(factor)`.
    """
    if factor == 1:
        return values
    columns = values.reshape(len(values), math.prod(values.shape[1:]))
    kept: FloatArray = _rows_of(len(values), factor) @ columns
    return kept.reshape(len(kept), *values.shape[1:])


@lru_cache(maxsize=16)
def _rows_of(samples: int, factor: int) -> csr_array:
    """Return the matrix from samples to the rows of a decimation; its product passes all columns at once."""
    taps = _low_pass(factor)[::-1]
    rows = max(0, (samples - len(taps)) // factor + 1)
    columns = factor * np.arange(rows)[:, None] + np.arange(len(taps))
    return csr_array((np.tile(taps, rows), columns.ravel(), len(taps) * np.arange(rows + 1)), shape=(rows, samples))


@cache
def _low_pass(factor: int) -> FloatArray:
    """Return the response of the low-pass of a decimation, shape (_LENGTH factor + 1,)."""
    return np.asarray(firwin(_LENGTH * factor + 1, _PASS / factor))


def edge(factor: int) -> int:
    """Return the number of samples that `decimate` leaves out at each end."""
    return _LENGTH * factor // 2 if factor > 1 else 0


def untouched_rows(spoilt: BoolArray, factor: int) -> BoolArray:
    """Mark the rows of `decimate` that depend on no spoilt sample.

    Args:
        spoilt: Spoilt samples, shape (n,).
        factor: Decimation factor.

    Returns:
        Marks, shape (m,).
    """
    if factor == 1:
        return ~spoilt
    before = np.concatenate([[0], np.cumsum(spoilt)])
    rows = (len(spoilt) - _LENGTH * factor - 1) // factor + 1
    first = factor * np.arange(rows)
    return np.asarray(before[first + _LENGTH * factor + 1] == before[first])


def check_rows(rows: int, parameters: int, motors: int = 1) -> None:
    """Reject records that are too short for a regression.

    Args:
        rows: Samples after decimation, with an equation for every motor each.
        parameters: Number of parameters.
        motors: Number of motors.

    Raises:
        InputError: There are too few rows.
    """
    least = max(_FEWEST, -(-2 * parameters // motors))
    if rows < least:
        raise InputError(
            f"{rows} samples are left after filtering and decimation, but {parameters} parameters need at least {least}"
            "; give a longer log or a higher cut-off"
        )
