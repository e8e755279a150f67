"""The torque that stands in for a continuous one while commands are held and delayed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def samples_ahead(sample_time: float, delay: float) -> int:
    """Number of samples beyond the present one that `held_torque` looks at.

    Args:
        sample_time: Time for which a command is held [s].
        delay: Time until it acts [s].

    Returns:
        Number of samples.
    """
    return split_delay(delay, sample_time).line_length + 1


def held_torque(load: FloatArray, momentum: FloatArray, sample_time: float, delay: float) -> FloatArray:
    """Average the torque over the interval in which the command acts.

    A command of t_k acts from t_k + delay to t_k + delay + T. Holding u(t_k) therefore lags the wanted torque by
    T / 2 + delay, an error of first order in T. Holding the mean over the interval gives the right momentum at its end
    and leaves an error of second order. The torque is u = load + d(momentum)/dt: the mean of the second part follows
    exactly from the momentum at both ends, also where the acceleration jumps; load and momentum are taken as
    linear between their samples.

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
    means = (0.5 * (1.0 - rest) ** 2, 0.5 + rest - rest**2, 0.5 * rest**2)
    slopes = ((rest - 1.0) / sample_time, (1.0 - 2.0 * rest) / sample_time, rest / sample_time)
    torque = np.zeros((n, load.shape[1]))
    for offset in range(3 if rest > 0.0 else 2):
        rows = slice(whole + offset, whole + offset + n)
        torque += means[offset] * load[rows] + slopes[offset] * momentum[rows]
    return torque
