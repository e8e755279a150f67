"""Hold and sampling: from the continuous model to the frequency response of sampled signals.

The command of t_k acts on [t_k + delay, t_{k+1} + delay) and the encoder is read at t_k. With W_m = w + m w_s the
response of sampled position to sampled command is (Pintelon and Schoukens 2001, section 10.2)

    G_s(w) = sum_m G(j W_m) H(W_m),    H(W) = (1 - exp(-j W T)) / (j W T) exp(-j W delay) .

The aliases m != 0 are far above all modes, where G(s) = C_2 / s^2 + C_3 / s^3 + C_4 / s^4 + ... with real matrices C,
so their sums over m are the same functions of frequency for all models.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray

ORDERS = (2, 3, 4, 5, 6)
"""Powers of 1/s that the aliases consist of, the mass line first (chosen: correct to 2e-9 at 100 Hz and 5e-7 at 300 Hz
for six_axis at 2 kHz; above a third of the sampling frequency the first alias is too close to the modes)."""
_ALIASES = 400  # the truncated sum of second order converges with the third power of this


@dataclass(frozen=True, eq=False)
class SampledHold:
    """Effect of hold, delay and sampling on a frequency response of motor accelerations.

    Acceleration means (jw)^2 times the response of the sampled position.

    Attributes:
        omega: Angular frequencies [rad/s], any shape (...).
        gain: (jw)^2 H(w), the factor on G(jw), shape (...).
        aliases: (jw)^2 sum over m != 0 of H(W_m) / (j W_m)^r for r in ORDERS, shape (..., 5).
    """

    omega: FloatArray
    gain: ComplexArray
    aliases: ComplexArray


def sampled_hold(frequency: FloatArray, sample_time: float, delay: float = 0.0) -> SampledHold:
    """Evaluate hold, delay and aliases at some frequencies.

    Args:
        frequency: Frequencies [Hz], any shape.
        sample_time: T [s].
        delay: Time from the sampling instant to the change of the torque [s].

    Returns:
        Factors of the continuous response and of its high-frequency expansion.

    Raises:
        InputError: A frequency is not between zero and half the sampling frequency.
    """
    frequency = np.ascontiguousarray(frequency, dtype=float)
    nyquist = 0.5 / sample_time
    if not np.all((frequency > 0) & (frequency < nyquist)):
        wrong = frequency[~((frequency > 0) & (frequency < nyquist))][0]
        raise InputError(
            f"a frequency of {wrong:g} Hz was given to the sampled model, but frequencies must lie between 0 and half "
            f"the sampling frequency, {nyquist:g} Hz; leave it out"
        )
    return _sampled_hold(frequency.tobytes(), frequency.shape, sample_time, delay)


@lru_cache(maxsize=8)
def _sampled_hold(frequencies: bytes, shape: tuple[int, ...], sample_time: float, delay: float) -> SampledHold:
    """Evaluate the factors once for all linearisations of a fit."""
    omega = 2 * np.pi * np.frombuffer(frequencies).reshape(shape)
    turns = 2 * np.pi / sample_time * np.concatenate([np.arange(-_ALIASES, 0), np.arange(1, _ALIASES + 1)])
    s = 1j * (omega[..., None] + turns)
    weighted = np.exp(-s * delay) / s
    step = (1.0 - np.exp(-1j * omega * sample_time)) / sample_time * (1j * omega) ** 2
    aliases = np.stack([step * np.sum(weighted / s**order, axis=-1) for order in ORDERS], axis=-1)
    return SampledHold(omega, step * np.exp(-1j * omega * delay) / (1j * omega), aliases)


def expansion(mass: FloatArray, damping: FloatArray, stiffness: FloatArray, motors: IntArray) -> FloatArray:
    """Compute the matrices C_r of G(s) = sum_r C_r / s^r, from (M s^2 + D s + K) sum_r X_r / s^r = B.

    Args:
        mass: M, shape (Q, n, n).
        damping: D, shape (Q, n, n).
        stiffness: K, shape (Q, n, n).
        motors: Rows of the motors among the coordinates, shape (M,).

    Returns:
        C_r for r in ORDERS, shape (Q, 5, M, M).
    """
    inverse = np.linalg.inv(mass)
    before = np.zeros_like(inverse[:, :, motors])
    terms = [inverse[:, :, motors]]
    while len(terms) < len(ORDERS):
        last = terms[-1]
        terms.append(-inverse @ (damping @ last + stiffness @ before))
        before = last
    return np.stack([term[:, motors] for term in terms], axis=1)
