"""Delay of held inputs by any number of samples: torques as held for half a sample each, position commands filtered."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

HALVES = 2
"""Parts of a sample with a constant torque each [1]: the fewest that keep impulse and moment of any torque."""
POLE = 0.95
"""Size of the pole of the filter at half the sampling rate; 1 is exact, but not damped [1] (chosen)."""


def delayed_halves(torque: FloatArray, samples: Sequence[float] | FloatArray) -> FloatArray:
    """Delay torques by any number of samples.

    Of a torque that is held from sample to sample and delayed by w + f samples, the one of sample k - w - 1 acts in the
    first part f of sample k, and that of k - w in the rest. A mass is moved by its impulse and by its moment about the
    end of the sample. Two torques that are held for half a sample each have the same of both for

        new + (3 f - 2 f^2) (old - new),   new + (2 f^2 - f) (old - new)

    from solving these two equations, so that position and speed at all samples are those of the delay, at all
    frequencies. One torque per sample has no moment of its own: only a filter whose pole is at half the sampling rate,
    where torques of a controller are full of noise, would keep the positions.

    Args:
        torque: Torques, each held from its sample to the next [Nm or N], shape (n, M).
        samples: Delay of each motor [samples], zero or more, length M.

    Returns:
        Torques to hold for half a sample each, shape (2 n, M); the first torque also acts before the first sample.
    """
    halves = np.empty((len(torque), HALVES, torque.shape[1]))
    for motor, late in enumerate(samples):
        whole = int(np.floor(late))
        f = late - whole
        new, old = (torque[np.maximum(np.arange(len(torque)) - age, 0), motor] for age in (whole, whole + 1))
        halves[:, 0, motor] = new + (3 * f - 2 * f**2) * (old - new)
        halves[:, 1, motor] = new + (2 * f**2 - f) * (old - new)
    return halves.reshape(-1, torque.shape[1])


def delayed_commands(commands: FloatArray, samples: float, motors: Sequence[int]) -> FloatArray:
    """Delay the position commands of servos by any number of samples.

    The torque behind a command may be at its limit, where a part of the halves of `delayed_halves` would be lost: a
    small delay of a step would do nothing. So one command per sample is filtered, by

        F(z) = ((1 - f)^2 z^2 + (1 + 2 f - 2 f^2) z + f^2) / (z (z + 1))

    which is the ratio of the responses T^2 / 2 (...) / (z - 1)^2 of a mass to both, from integrating the two pieces of
    a sample. Its pole is moved from -1 to -0.95, and its zeros such that value, slope and curvature at frequency zero
    remain those of the delay. Commands have little at half the sampling rate, where that is no delay.

    Args:
        commands: Commands, each held from its sample to the next [rad or m], shape (n, M).
        samples: The delay [samples], zero or more.
        motors: Indices of the motors whose commands are delayed.

    Returns:
        Commands to hold, shape (n, M); the first one also acts before the first sample.
    """
    whole = int(np.floor(samples))
    fraction = samples - whole
    rows = np.maximum(np.arange(len(commands)) - whole, 0)
    result = np.array(commands)
    for motor in motors:
        late = commands[rows, motor]
        result[:, motor] = late[0] + lfilter(*_filter(fraction), late - late[0]) if fraction > 0.0 else late
    return result


def _filter(fraction: float) -> tuple[FloatArray, FloatArray]:
    """Numerator and denominator in powers of 1/z."""
    share = POLE / (1.0 + POLE)
    last = 0.5 * (fraction**2 - fraction) + fraction * share
    middle = fraction + share - 2.0 * last
    numerator = np.array([1.0 - middle - last, middle, last]) * (1.0 + POLE)
    return numerator, np.array([1.0, POLE])
