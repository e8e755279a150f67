"""Torques that acted against inverse-dynamics torques of the nominal robot, by frequency.

Below a third of the lowest resonance with locked motors the inverse dynamics are those of the rigid arm in any pose;
above, those of the linearised elastic robot at the mean pose. The control law does not enter, and friction is the only
effect that is fitted, with the inertia of rotors that the robot file leaves out: a wrong unit, sign or order of joints
changes the balance more than any other effect (chosen).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, ComplexArray, FloatArray, IntArray

FEWEST_BINS, FEWEST_BANDS = 12, 3
"""Fewest clear frequencies and half octaves of a comparison (chosen)."""

LEAST_REST = 1e-3
"""Power of the inverse-dynamics torque that friction and an unknown rotor cannot explain, over all of it, from which a
torque is compared with it [1] (chosen)."""

WORTH = 0.02
"""Gain in mean agreement above which a rough delay is accepted (chosen)."""

AGREED = 0.7
"""Mean agreement above which a rough delay is accepted: torques without agreement at any time are not late (chosen)."""

COHERENT = 0.8
"""Least cosine between torque and inverse-dynamics torque of a band whose phase is used for a delay (chosen)."""

LEAST_PHASE = 0.01
"""Standard deviation added to that of every phase, because the model is not exact [rad] (chosen)."""

FEWEST_PHASES, WIDEST = 3, 2.0
"""Fewest bands with a usable phase, and ratio of the highest to the lowest of their frequencies, from which a delay is
told from the error of a damper (chosen): in slow motion friction shifts the phase of one or two bands by more."""

IN_LINE = 3.0
"""Standard deviations up to which a phase counts as zero (chosen)."""

MODEL_SHARE = 0.1
"""Share of the torque without inverse-dynamics torque that counts as an error of the phase of a band (chosen)."""

STEP = 0.02
"""Relative step of the multiples that are tried (chosen)."""

LONGEST_DELAY = 0.03
"""Longest time between torque and motion of the search [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """Agreement of a torque with an inverse-dynamics torque, apart from friction and unknown rotors.

    The agreement of torque u with a multiple s of the inverse-dynamics torque n in one band is
    2 Re(u* s n) / (|u|^2 + |s n|^2): 1 where both are equal, 0 where they are unrelated, -1 where they are opposite.

    Attributes:
        factor: Multiple of the inverse-dynamics torque that agrees best; negative for opposite directions.
        agreement: Mean agreement over the bands with that multiple, 0 ... 1.
        as_is: Mean agreement without a factor, -1 ... 1.
    """

    factor: float
    agreement: float
    as_is: float


@dataclass(frozen=True, eq=False)
class BalanceFit(Agreement):
    """Agreement by band, and what all bands together show.

    Attributes:
        correlation: Cosine between both over all bands together, -1 ... 1. Where gravity dominates it is that of the
            slow bands, and noise of the others does not count.
        share: Power of the torque that friction and an unknown rotor leave, over all of it, 0 ... 1.
    """

    correlation: float
    share: float


@dataclass(frozen=True, eq=False)
class TorqueBalance:
    """Spectra at the frequencies that were kept.

    Attributes:
        frequency: Frequencies [Hz], shape (F,).
        band: Number of the half octave of each, shape (F,).
        given: Torques that acted, shape (F, M).
        needed: Inverse-dynamics torques of the nominal robot, shape (F, M).
        own: Speed of each motor, its sign, and its acceleration where the rotor inertia is unknown, else 0, shape
            (F, M, 3).
        clear: Where the motion is clear of the noise of the encoder, shape (F, M).
    """

    frequency: FloatArray
    band: IntArray
    given: ComplexArray
    needed: ComplexArray
    own: ComplexArray
    clear: BoolArray

    def fit(self, torque: int, motion: int, delay: float = 0.0) -> BalanceFit | None:
        """Compare the torque of one motor with the inverse-dynamics torque of the same or another one.

        Args:
            torque: Motor whose torque it is.
            motion: Motor whose motion it is.
            delay: Delay of the torque with respect to its stamp [s].

        Returns:
            The comparison; None where there is no agreement.
        """
        by_band = self.agreement(torque, motion, delay)
        if by_band is None:
            return None
        use = self.clear[:, motion]
        given, needed = self._compared(torque, motion, delay)
        whole = float(_sums(self._bands(motion)[1], np.abs(given) ** 2).sum())
        strong, strong_need = (_without(self.own[use, motion], part, np.ones(len(part))) for part in (given, needed))
        correlation, share = _correlation_and_share(strong, strong_need, whole)
        return BalanceFit(by_band.factor, by_band.agreement, by_band.as_is, correlation, share)

    def agreement(self, torque: int, motion: int, delay: float = 0.0) -> Agreement | None:
        """Compare the torque of one motor with the inverse-dynamics torque of the same or another one, band by band.

        Args:
            torque: Motor whose torque it is.
            motion: Motor whose motion it is.
            delay: Delay of the torque with respect to its stamp [s].

        Returns:
            The agreement; None where too little of the motion is clear of noise, or where friction and an unknown
            rotor would explain all of the inverse-dynamics torque.
        """
        use = self.clear[:, motion]
        bands, index = self._bands(motion)
        if use.sum() < FEWEST_BINS or len(bands) < FEWEST_BANDS:
            return None
        given, needed = self._compared(torque, motion, delay)
        power, need = (_sums(index, np.abs(part) ** 2) for part in (given, needed))
        if not (power.max() > 0 and need.max() > 0):
            return None
        level = float(np.median(power) / max(float(np.median(need)), 1e-300))
        weight = (1 / (power + level * need + 1e-12 * power.max()))[index]
        rest, need_rest = (_without(self.own[use, motion], part, weight) for part in (given, needed))
        whole = float(need.sum())
        power, need = (_sums(index, np.abs(part) ** 2) for part in (rest, need_rest))
        if need.sum() < LEAST_REST * whole:
            return None
        return Agreement(*_agreement(power, need, _sums(index, (np.conj(need_rest) * rest).real)))

    def _bands(self, motion: int) -> tuple[IntArray, IntArray]:
        """Return the half octaves in which the motion of a motor is clear, and the place of each frequency in them."""
        bands, index = np.unique(self.band[self.clear[:, motion]], return_inverse=True)
        return bands, index

    def _compared(self, torque: int, motion: int, delay: float) -> tuple[ComplexArray, ComplexArray]:
        """Return the delayed torque and the inverse-dynamics torque at the frequencies where the motion is clear."""
        use = self.clear[:, motion]
        given = self.given[use, torque] * np.exp(-2j * np.pi * self.frequency[use] * delay)
        return given, self.needed[use, motion]

    def unexplained(self, torque: int, motion: int, delay: float = 0.0) -> float:
        """Return the power of a torque that the motion of a motor leaves unexplained, over all of it, 0 ... 1.

        Friction, the inertia of an unknown rotor and any multiple of the inverse-dynamics torque are fitted to all
        frequencies alike. The torque of another motor has no part in the motion, whatever the model lacks.

        Args:
            torque: Motor whose torque it is.
            motion: Motor whose motion it is.
            delay: Delay of the torque with respect to its stamp [s].
        """
        use = self.clear[:, motion]
        given, needed = self._compared(torque, motion, delay)
        power = float(np.sum(np.abs(given) ** 2))
        if use.sum() < FEWEST_BINS or power == 0:
            return 1.0
        regressors = np.column_stack([needed, self.own[use, motion]])
        return float(np.sum(np.abs(_without(regressors, given, np.ones(len(given)))) ** 2)) / power

    def delay(self) -> Delay:
        """Estimate the delay of the torques with respect to their stamps, in addition to the delay of the robot.

        A search finds the time at which torques and inverse-dynamics torques agree best. The remaining phases are
        fitted by -w tau + c / w: a delay, and the error of a damper. Agreement hardly falls with a phase that is small
        and clear, and a resonance that the model lacks turns others by half a period; so a time counts only where it
        brings as many phases in line as none does.
        """
        motors = range(self.given.shape[1])
        step = 0.1 / self.frequency[np.any(self.clear, axis=1)].max(initial=1.0)
        count = int(np.ceil(LONGEST_DELAY / step))
        tried = np.arange(-count, count + 1) * step
        shares = np.zeros(len(tried))
        for motor in motors:
            fits = [self.agreement(motor, motor, float(tau)) for tau in tried]
            shares += [0.0 if fit is None else np.copysign(fit.agreement, fit.factor) for fit in fits]
        shares /= len(motors)
        best = int(np.argmax(np.abs(shares)))
        better = float(abs(shares[best]) - abs(shares[count]))
        rough = float(tried[best]) if better > WORTH and abs(shares[best]) > AGREED else 0.0
        if rough and sum(self._in_line(motor, rough) - self._in_line(motor, 0.0) for motor in motors) < 0:
            rough = 0.0
        slopes = [slope for motor in motors for slope in self._phase_slopes(motor, rough)]
        if not slopes:
            return Delay(rough, float("inf"), better)
        tau, deviation = _common_delay(np.array(slopes))
        return Delay(rough + tau, deviation, better)

    def _phase_slopes(self, motor: int, delay: float) -> list[tuple[float, float, float]]:
        """Return angular frequency [rad/s], lead of the torque [s] and its deviation [s] of every clear band."""
        use = self.clear[:, motor]
        slopes = []
        for band in np.unique(self.band[use]):
            rows = use & (self.band == band)
            w = 2 * np.pi * self.frequency[rows]
            product = np.conj(self.needed[rows, motor]) * self.given[rows, motor] * np.exp(-1j * w * delay)
            power = np.sqrt(
                np.sum(np.abs(self.needed[rows, motor]) ** 2) * np.sum(np.abs(self.given[rows, motor]) ** 2)
            )
            share = float(product.real.sum() / power) if power > 0 else 0.0
            if share < COHERENT or rows.sum() < 4:
                continue
            size = float(np.sum(w**2 * product.real))
            tau = float(np.sum(w * product.imag)) / size
            middle = float(np.sqrt(size / product.real.sum()))
            slopes.append((middle, tau, _phase_deviation(share, int(rows.sum())) / middle))
        return slopes

    def _in_line(self, motor: int, delay: float) -> int:
        """Count the clear bands whose phase is zero, within its deviation, when the torque is delayed [s]."""
        use = self.clear[:, motor]
        count = 0
        for band in np.unique(self.band[use]):
            rows = use & (self.band == band)
            needed, given = self.needed[rows, motor], self.given[rows, motor]
            mean = np.sum(np.conj(needed) * given * np.exp(-2j * np.pi * self.frequency[rows] * delay))
            power = np.sqrt(np.sum(np.abs(needed) ** 2) * np.sum(np.abs(given) ** 2))
            share = float(np.abs(mean) / power) if power > 0 else 0.0
            if share >= COHERENT and rows.sum() >= 4:
                count += abs(np.angle(mean)) < IN_LINE * _phase_deviation(share, int(rows.sum()))
        return count


@dataclass(frozen=True)
class Delay:
    """Time between torque and motion.

    Attributes:
        time: Delay of the torque with respect to its stamp [s]; negative where it acts earlier.
        deviation: Its standard deviation [s]; infinite without a usable phase.
        better: Gain in mean agreement by the rough delay.
    """

    time: float
    deviation: float
    better: float


def _phase_deviation(share: float, n_frequencies: int) -> float:
    """Return the standard deviation of the phase of a band [rad], from the share of coherent torque [1]."""
    other = np.sqrt(max(1 - share**2, 0.0))
    return float(np.hypot(other / np.sqrt(n_frequencies) / share, np.hypot(LEAST_PHASE, MODEL_SHARE * other)))


def _common_delay(slopes: FloatArray) -> tuple[float, float]:
    """Fit a delay and c / w^2 robustly to delays of bands, shape (n, 3); return the delay and its deviation [s]."""
    w, tau, deviation = slopes.T
    if len(w) < FEWEST_PHASES or w.max() < WIDEST * w.min():
        return float(np.median(tau)), float("inf")  # a delay and the error of a damper look the same
    weight = np.ones(len(w))
    regressors = np.stack([np.ones(len(w)), (w.min() / w) ** 2], axis=1) / deviation[:, None]
    solution, spread = np.zeros(2), 1.0
    for _ in range(10):
        root = np.sqrt(weight)[:, None]
        solution, *_ = np.linalg.lstsq(root * regressors, root[:, 0] * tau / deviation, rcond=1e-3)
        off = tau / deviation - regressors @ solution
        spread = max(1.0, 1.48 * float(np.median(np.abs(off))))
        weight = 1 / np.maximum(1.0, np.abs(off) / (1.5 * spread))
    inverse = np.linalg.pinv(regressors.T @ (weight[:, None] * regressors), rcond=1e-6)
    return float(solution[0]), float(np.sqrt(inverse[0, 0]) * spread)


def _sums(index: IntArray, values: FloatArray) -> FloatArray:
    """Sum values of equal index."""
    return np.asarray(np.bincount(index, values), dtype=np.float64)


def _agreement(power: FloatArray, need: FloatArray, product: FloatArray) -> tuple[float, float, float]:
    """Return the factor with the best mean agreement, that agreement and the one without a factor.

    All powers are those of the bands, shape (n_bands,).
    """

    def mean(factor: FloatArray) -> FloatArray:
        s = factor[:, None]
        share = 2 * s * product / np.maximum(power + s**2 * need, 1e-300)
        return np.asarray(np.where(power > 1e-12 * power.max(), share, 0.0).mean(axis=1))

    middle = float(np.sqrt(np.median(power[need > 0] / need[need > 0])))
    sizes = middle * np.exp(np.arange(-2.0, 2.0, STEP))
    tried = np.concatenate([sizes, -sizes])
    agreement = mean(tried)
    best = int(np.argmax(agreement))
    return float(tried[best]), float(agreement[best]), float(mean(np.ones(1))[0])


def _correlation_and_share(given: ComplexArray, needed: ComplexArray, whole: float) -> tuple[float, float]:
    """Return the cosine between two torques, and the power of the first one over a whole."""
    power, need = (float(np.sum(np.abs(part) ** 2)) for part in (given, needed))
    size = float(np.sqrt(power * need))
    return float(np.sum(np.conj(needed) * given).real) / size if size > 0 else 0.0, power / whole


def _without(regressors: ComplexArray, values: ComplexArray, weight: FloatArray) -> ComplexArray:
    """Remove the part explained by real multiples of regressors."""
    root = np.sqrt(weight)
    scale = np.maximum(np.linalg.norm(root[:, None] * regressors, axis=0), 1e-300)
    matrix, right = root[:, None] * regressors / scale, root * values
    stacked = np.vstack([matrix.real, matrix.imag])
    solution, *_ = np.linalg.lstsq(stacked, np.concatenate([right.real, right.imag]), rcond=1e-6)
    return np.asarray(values - regressors / scale @ solution)
