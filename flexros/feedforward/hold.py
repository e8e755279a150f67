"""Compensation of hold and delay: the mean torque over the interval in which a command acts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def samples_ahead(sample_time: float, delay: float) -> int:
    """Return the number of samples beyond the present one that `held_torque` needs.

    Args:
        sample_time: Time for which a command is held [s].
        delay: Time until it acts [s].
    """
    return split_delay(delay, sample_time).line_length + 1


def held_torque(load: FloatArray, momentum: FloatArray, sample_time: float, delay: float) -> FloatArray:
    """Average the torque over the interval in which the command acts.

    A command of t_k acts from t_k + delay to t_k + delay + T. Holding u(t_k) therefore lags the required torque by
    T / 2 + delay, an error of first order in T. Holding the mean over the interval yields the correct momentum at its
    end and leaves an error of second order. The torque is u = load + d(momentum)/dt. The mean of the second term
    follows exactly from the momentum at both ends, even if the acceleration jumps. Load and momentum are linear between
    their samples.

    Args:
        load: Torque through the gear at the sampling instants [Nm or N], shape (n + samples_ahead, M).
        momentum: Momentum of the motor's own inertia [Nms or Ns], same shape.
        sample_time: Time T for which a command is held [s].
        delay: Time until it acts [s].

    Returns:
        Torque to command, shape (n, M).
    """
    split = split_delay(delay, sample_time)
    whole, rest = split.whole, split.fraction
    n = len(load) - samples_ahead(sample_time, delay)
    # the interval covers parts of at most three samples: integrals of the linear interpolation, and end values of it
    means = (0.5 * (1.0 - rest) ** 2, 0.5 + rest - rest**2, 0.5 * rest**2)
    slopes = ((rest - 1.0) / sample_time, (1.0 - 2.0 * rest) / sample_time, rest / sample_time)
    torque = np.zeros((n, load.shape[1]))
    for offset in range(3 if rest > 0.0 else 2):
        rows = slice(whole + offset, whole + offset + n)
        torque += means[offset] * load[rows] + slopes[offset] * momentum[rows]
    return torque
