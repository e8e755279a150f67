"""Spectra of torques and inverse-dynamics torques: short stretches by pose, and the whole record of the rigid arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.balance.inverse_dynamics import ElasticInverseDynamics, rigid_inverse_dynamics
from flexros.record.balance.torque_balance import TorqueBalance
from flexros.record.missing_samples import bridged, bridged_motion, long_holes, runs
from flexros.record.smoothing import noise_power, smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, ComplexArray, FloatArray, IntArray
    from flexros.record.record import Record
    from flexros.robot import Robot

STRETCH = 4.0
"""Length of a stretch that is linearised at its mean pose [s] (chosen)."""

BINS = 96
"""Number of strongest frequencies of each half octave, over all stretches (chosen)."""

LEAST_BINS = 6
"""Fewest frequencies of each stretch and half octave (chosen)."""

HIGHEST = 0.2
"""Highest frequency over the sampling rate (chosen)."""

RIGID_SHARE = 1 / 3
"""Share of the lowest resonance with locked motors up to which the arm counts as rigid (chosen)."""

RIGID_HIGHEST = 20.0
"""Highest frequency at which the rigid arm is used [Hz] (chosen)."""

NOISE_SHARE = 0.1
"""Largest share of encoder noise in the power of a clear motion (chosen)."""

_LONG = 1_000_000  # samples from which a transform of any length would need too much memory
_FIRST_BAND = 1e-4  # lowest frequency of half octave 0 [Hz]
_PERIODS = 4  # periods of the lowest frequency in a stretch


@dataclass(frozen=True, eq=False)
class _Signals:
    """Signals in time, without the first and the last sample, each of shape (n, M).

    `rotor_unknown` marks the motors whose rotor inertia the robot file leaves out, shape (M,).
    """

    sample_time: float
    position: FloatArray
    acceleration: FloatArray
    given: FloatArray
    rigid: FloatArray
    sign: FloatArray
    noise: FloatArray
    rotor_unknown: BoolArray
    rigid_below: float
    delay: float

    def spectra(
        self, first: int, end: int, low: float, high: float, bins: int, need: ElasticInverseDynamics | None
    ) -> _Piece:
        """Transform a stretch between two frequencies; above `rigid_below` the robot is elastic."""
        T, window = self.sample_time, np.hanning(end - first)
        part = slice(first, end)
        frequency = np.asarray(np.fft.rfftfreq(end - first, T), dtype=np.float64)
        inside = slice(*np.searchsorted(frequency, (low, high)))
        mean = {name: getattr(self, name)[part].mean(axis=0) for name in ("given", "rigid")}
        given, acceleration, rigid, sign = (
            _spectra(window, getattr(self, name)[part], mean.get(name), inside.stop)
            for name in ("given", "acceleration", "rigid", "sign")
        )
        kept, band, crowd = _strongest(frequency, inside, given, acceleration, bins)
        f = frequency[kept]
        w = np.asarray(2 * np.pi * f, dtype=np.float64)
        q = -acceleration[kept] / ((2 * np.sin(w * T / 2) / T) ** 2)[:, None]
        needed, elastic = rigid[kept], f >= self.rigid_below
        if need is not None and np.any(elastic):
            needed[elastic] = np.matmul(need.at(w[elastic], self.position[part].mean(axis=0)), q[elastic, :, None])[
                ..., 0
            ]
        hold = np.sinc(f * T) * np.exp(-1j * w * (T / 2 + self.delay))
        rotor = np.where(self.rotor_unknown, -((w**2)[:, None]) * q, 0.0)
        own = np.stack([1j * w[:, None] * q, sign[kept], rotor], axis=2)
        clear = _clear(np.abs(q) ** 2, band, crowd, float(np.sum(window**2)) * self.noise)
        return _Piece(f, band, given[kept] * hold[:, None], needed, own, clear)


_Piece = TorqueBalance  # spectra of one stretch have the form of the whole


def torque_balance(record: Record, robot: Robot, sample_time: float | None = None) -> TorqueBalance | None:
    """Compare torques with motions.

    Args:
        record: The record.
        robot: The nominal robot.
        sample_time: Time between two samples, instead of that of the record [s].

    Returns:
        The balance; None where the robot has no equilibrium near the motion.
    """
    T = record.sample_time if sample_time is None else sample_time
    position = bridged_motion(record.position, record.valid)
    length, starts = _stretches(record, T)
    try:
        need = ElasticInverseDynamics.of(robot, np.stack([position[1:-1][k : k + length].mean(axis=0) for k in starts]))
    except InputError:
        return None
    signals = _signals(record, robot, position, T, need.lowest)
    lowest, highest = _PERIODS / (length * T), HIGHEST / T
    bins = max(LEAST_BINS, BINS // len(starts))
    pieces = [signals.spectra(int(k), int(k) + length, lowest, highest, bins, need) for k in starts]
    slow = min(lowest, signals.rigid_below)
    whole = _transformed(len(position) - 2)
    if len(starts) > 1 and not np.any(long_holes(record.valid)) and slow > _PERIODS / (whole * T):
        pieces.append(signals.spectra(0, whole, _PERIODS / (whole * T), slow, BINS, None))
    return TorqueBalance(
        *(
            np.concatenate([getattr(piece, name) for piece in pieces])
            for name in ("frequency", "band", "given", "needed", "own", "clear")
        )
    )


def _transformed(samples: int) -> int:
    """Return how many samples of a whole record are transformed: of a long one with a large prime factor not all."""
    from scipy.fft import next_fast_len  # here, because it loads slowly

    while samples > _LONG and next_fast_len(samples, real=True) != samples:
        samples -= 1
    return samples


def _stretches(record: Record, T: float) -> tuple[int, IntArray]:
    """Return length and starts of the stretches that are transformed, all between long holes."""
    begins, lengths = runs(~long_holes(record.valid))
    lengths -= 2  # the first and the last sample have no acceleration
    length = min(int(lengths.max()), round(STRETCH / T))
    starts = [np.arange(begin, begin + n - length + 1, length) for begin, n in zip(begins, lengths, strict=True)]
    return length, np.concatenate(starts)


def rotor_unknown(robot: Robot) -> BoolArray:
    """Mark the motors whose rotor inertia the robot file leaves out, as one made from a URDF does, shape (M,).

    The one mass of a single drive is that of all its parts, so nothing is left out.

    Args:
        robot: The nominal robot.
    """
    left_out = np.array([robot.parameters[f"{name}.inertia"].value == 0 for name in robot.joint_names])
    return left_out & (robot.n_motors > 1)


def _signals(record: Record, robot: Robot, position: FloatArray, T: float, lowest: float) -> _Signals:
    rigid_below = min(RIGID_SHARE * lowest, RIGID_HIGHEST, 0.05 / T)
    cutoff = min(0.05 / T, 4 * RIGID_HIGHEST)
    # One motor after the other: three derivatives of all motors of a long record would be as large as the record.
    sign = [np.sign(smooth_motion(column[:, None], T, cutoff)[1]) for column in position.T]
    return _Signals(
        sample_time=T,
        position=position[1:-1],
        acceleration=np.diff(position, 2, axis=0) / T**2,
        given=bridged(record.torque, record.valid)[1:-1],
        rigid=rigid_inverse_dynamics(robot, position, T, rigid_below)[1:-1],
        sign=np.hstack(sign)[1:-1],
        noise=noise_power(position),
        rotor_unknown=rotor_unknown(robot),
        rigid_below=rigid_below,
        delay=0.0 if record.measured_torque else robot.delay,
    )


def _spectra(window: FloatArray, values: FloatArray, mean: FloatArray | None, below: int) -> ComplexArray:
    """Transform signals less their mean, one by one: of a long record all frequencies at once would need much memory.

    Returns:
        The lowest frequencies, shape (below, M).
    """
    columns = values.T if mean is None else (column - own for column, own in zip(values.T, mean, strict=True))
    return np.stack([np.fft.rfft(window * column)[:below].copy() for column in columns], axis=1)


def _strongest(
    frequency: FloatArray, inside: slice, given: ComplexArray, acceleration: ComplexArray, bins: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Select the strongest frequencies of each half octave; return indices, bands, and how many each represents."""
    indices = np.arange(inside.start, inside.stop)
    number = np.floor(2 * np.log2(frequency[indices] / _FIRST_BAND)).astype(np.int64)
    kept, crowd = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for band in np.unique(number):
        among = indices[number == band]
        strength = np.zeros(len(among))
        for part in (given[among], acceleration[among]):
            power = np.abs(part) ** 2
            strength += np.sum(power / np.maximum(power.sum(axis=0), 1e-300), axis=1)
        best = np.sort(among[np.argsort(strength)[-bins:]])
        kept.append(best)
        crowd.append(np.full(len(best), len(among) / len(best)))
    chosen = np.concatenate(kept)
    return chosen, number[chosen - inside.start], np.concatenate(crowd)


def _clear(power: FloatArray, band: IntArray, crowd: FloatArray, noise: FloatArray) -> BoolArray:
    """Mark bands whose selected frequencies are clear of noise, allowing for the selection of its strongest ones."""
    _, index = np.unique(band, return_inverse=True)
    count = np.bincount(index)
    mean = np.stack([np.bincount(index, column) / count for column in power.T], axis=1)
    peaks = 1 + np.log(np.bincount(index, crowd) / count)
    return np.asarray((mean * NOISE_SHARE > peaks[:, None] * noise)[index])
