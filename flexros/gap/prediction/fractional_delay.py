"""Delay of held torques by any number of samples, as torques held for half a sample each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

HALVES = 2
"""Parts of a sample with a constant torque each [1]: the fewest that keep impulse and moment of any torque."""


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
