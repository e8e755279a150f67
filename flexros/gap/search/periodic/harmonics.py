"""Harmonics of the rotor angle in the prediction errors: their orders, and where they enter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.fft import fft, ifft, next_fast_len
from scipy.linalg import expm
from scipy.signal import find_peaks, lfilter

from flexros.effects.kinds.ranges import HIGHEST_ORDER
from flexros.gap.fit.least_norm import least_norm
from flexros.gap.settings import SearchSettings
from flexros.record.quantization import encoder_step
from flexros.robot.linear.linearise import linear_model
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.effects.kinds.ranges import Entry
    from flexros.gap.residuals.fit_data import FitData
    from flexros.robot import Robot

SEARCH = SearchSettings()
"""Settings of a search for orders unless others are given."""
POINTS = 8
"""Points of the grid of angles per shortest period [1]."""
VALLEYS = np.array([index for index in range(-8, 9) if index])
"""Neighbours of an order that are tried as well, in half turns over the travel of the rotor in a log [1]."""
FEWEST_MEASURED = 2.0
"""Fewest periods of a harmonic over the travel of a rotor from which orders are sought in a measured log [1] (chosen):
with fewer it is like a torque over the angle that no law explains, as of a cable."""
LEAST_MEASURED = 1.5
"""Periods down to which such an order moves in a fit [1] (chosen): 1.0 stood for a chain of cables, and with 1.75 less
of another log of a measured arm is left."""
NOISE = (1e-1, 1e-2, 1e-3)
"""Powers of the noise of the errors over the largest of a disturbance of unit power [1] (chosen)."""
BY_STEPS = 0.5
"""Highest order over the steps of an encoder in a turn of the rotor [1] (chosen): two steps show a period."""
MOST_AT_ONE = 3.0
"""Most samples at an angle that count, over the median of all angles [1] (chosen)."""
AT_REST = 0.05
"""Speed over about the highest one below which a rotor counts as at rest [1] (chosen)."""
PADDING = 4
"""Spacing of the orders: so many times finer than their resolution [1]."""
MANY = 24
"""Filters of single modes, one per motor, from which one convolution with their sum takes less time [1] (chosen)."""
KEPT = 4
"""Responses of entries that are kept for such convolutions: those of one motor [1]."""


@dataclass(frozen=True)
class HarmonicFit:
    """The best harmonic of one order.

    Attributes:
        order: Periods per turn of the rotor [1].
        amplitude: Amplitude [Nm, 1 or rad].
        phase: Phase at motor position zero [rad].
        gain: Twice the expected gain in log-likelihood.
    """

    order: float
    amplitude: float
    phase: float
    gain: float


class OrderSearch:
    """Finds harmonics of a rotor angle a in the prediction errors of a log, by linear theory about its pose.

    A disturbance d at an entry makes prediction errors e = H d with the error dynamics x <- F x + G d, e = C x + D d.
    The gain of order n is that of a least-squares fit of H sin(n a) and H cos(n a) to the errors. Which orders to fit
    shows the sum of d exp(i n a) over all samples, where d is the disturbance that the errors suggest: H inverted where
    it exceeds a share of its maximum. By H* e alone, slow parts of the motion, where H is large and few periods pass,
    hide the order: the true one came behind many others.

    Args:
        robot: The nominal robot.
        data: Log, gain and weights.
        residual: Weighted prediction errors that are to be explained, those of the motors first, shape (n_values,).
        states: Predicted states [q, v], shape (n, n_states).
        q_a: Arm coordinates of the pose of the gain [rad or m], shape (N,).
        settings: How many orders are fitted, and up to which frequency.
    """

    def __init__(
        self,
        robot: Robot,
        data: FitData,
        residual: FloatArray,
        states: FloatArray,
        q_a: FloatArray | None = None,
        settings: SearchSettings = SEARCH,
    ) -> None:
        self.robot, self.data, self._settings = robot, data, settings
        self._residual = residual[: data.spread.size].reshape(robot.n_motors, -1).T
        self._states = states
        self._linear = linear_model(_with_mean_stiffness(robot, states), q_a)
        A, _, measurement, _ = self._linear.matrices()
        correct = np.eye(len(A)) - data.gain.gain @ measurement[: robot.n_motors]
        self._stiffenings: dict[int, FloatArray | float] = {}
        self._sources: dict[tuple[int, Entry], tuple[FloatArray, FloatArray]] = {}
        self._spectra: dict[bytes, ComplexArray] = {}
        self._eigenvalues, self._modes = np.linalg.eig(expm(A * data.record.sample_time) @ correct)

    def search(self, motor: int, entry: Entry, most: int = 2) -> tuple[HarmonicFit, ...]:
        """Find the best orders, the best one compared with its neighbours.

        Args:
            motor: Index of the motor.
            entry: Where the disturbance enters.
            most: Largest number of harmonics returned.

        Returns:
            Harmonics by gain, the largest first.
        """
        angle, resolution = self._angle(motor), self._resolution(motor)
        lowest = resolution * (1.0 if self.data.record.premises.library_is_complete else FEWEST_MEASURED)
        highest = self._highest(motor, angle)
        if highest <= lowest:
            return ()
        factor, chosen = self._factor(motor, entry), set[float]()
        even = evenly(angle, highest)
        for disturbance in self._disturbances(self._source(motor, entry)):
            orders, score = angle_spectrum(disturbance * factor * even, angle, highest)
            orders, score = orders[orders >= lowest], score[orders >= lowest]
            peaks = find_peaks(score, distance=PADDING)[0]
            largest = peaks[np.argsort(-score[peaks])[: self._settings.tried_orders]]
            chosen.update(map(float, orders[largest]))
        fits = [self.fit(motor, entry, order) for order in sorted(chosen)]
        best = sorted(fits, key=lambda fit: -fit.gain)[:most]
        if not best:
            return ()
        valleys = best[0].order + resolution / 2 * VALLEYS
        near = [self.fit(motor, entry, order) for order in valleys if lowest <= order <= highest]
        nearest = max(near, key=lambda fit: fit.gain, default=best[0])
        if nearest.gain > best[0].gain:  # by linear theory: the peak of the spectrum stays a start
            best = [nearest, *best][:most]
        spacing = resolution / PADDING

        def refined(fit: HarmonicFit, spacing: float) -> HarmonicFit:
            inside = lowest <= fit.order - spacing and fit.order + spacing <= highest
            return self._refined(motor, entry, fit, spacing) if inside else fit

        first, *others = sorted((refined(fit, spacing) for fit in best), key=lambda fit: -fit.gain)
        return refined(first, spacing / PADDING), *others

    def least(self, motor: int) -> float:
        """Return the lowest order to which one moves in a fit at a motor [1]; 0 in a simulated log."""
        return 0.0 if self.data.record.premises.library_is_complete else LEAST_MEASURED * self._resolution(motor)

    def _resolution(self, motor: int) -> float:
        """Return the order of one period over the travel of a rotor [1]."""
        return 2 * np.pi / max(float(np.ptp(self._angle(motor))), 1e-12)

    def _refined(self, motor: int, entry: Entry, middle: HarmonicFit, spacing: float) -> HarmonicFit:
        """Move an order to the maximum of its gain, by a parabola through three orders at a distance."""
        low, high = (self.fit(motor, entry, middle.order + way * spacing) for way in (-1, 1))
        curvature = low.gain - 2 * middle.gain + high.gain
        way = 0.5 * (low.gain - high.gain) / curvature if curvature < 0 else 0.0
        last = self.fit(motor, entry, middle.order + float(np.clip(way, -1.0, 1.0)) * spacing)
        return max((low, middle, high, last), key=lambda fit: fit.gain)

    def fit(self, motor: int, entry: Entry, order: float) -> HarmonicFit:
        """Fit the harmonic of one order.

        Args:
            motor: Index of the motor.
            entry: Where the disturbance enters.
            order: Periods per turn of the rotor [1].
        """
        angle, factor = self._angle(motor), self._factor(motor, entry)
        if entry != "encoder":  # a torque acts by its mean over a sample
            factor = factor * np.sinc(order * np.gradient(angle) / (2 * np.pi))
        errors = self._forward(self._source(motor, entry), np.exp(1j * order * angle) * factor)
        X = self.data.weighted(np.stack([errors.imag, errors.real], axis=-1))
        r = self._residual.T.ravel()
        solution = least_norm(X.T @ X, X.T @ r)
        gain = float(solution @ (X.T @ r))
        return HarmonicFit(order, float(np.hypot(*solution)), float(np.arctan2(solution[1], solution[0])), gain)

    def _angle(self, motor: int) -> FloatArray:
        angle: FloatArray = self.robot.rotor_turns[motor] * self._states[:, self.robot.motor_rows[motor]]
        return angle

    def _highest(self, motor: int, angle: FloatArray) -> float:
        """Return the highest order that the sample time resolves in half of the motion, and the encoder by its steps.

        What is rounded to steps errs with their order.
        """
        steps = np.abs(np.diff(angle))
        moving = steps[steps > AT_REST * np.quantile(steps, 0.95)]
        middle = float(np.median(moving)) if moving.size else 0.0
        step = float(abs(self.robot.rotor_turns[motor])) * encoder_step(self.data.record, motor)
        return min(
            HIGHEST_ORDER,
            2 * np.pi * self._settings.fastest_order / max(middle, 1e-12),
            2 * np.pi * BY_STEPS / max(step, 1e-12),
        )

    def _factor(self, motor: int, entry: Entry) -> FloatArray | float:
        """Return the factor of the harmonic at its entry: the torque, or the stiffness over the linear one."""
        if entry == "proportional torque":
            return self.data.record.torque[:, motor]
        return self._stiffening(motor) if entry == "gear" else 1.0

    def _stiffening(self, motor: int) -> FloatArray | float:
        """Return the local stiffness of a gear along the motion over that of the linear model, shape (n,)."""
        if motor not in self._stiffenings:
            gear, row = self.robot.gear_rows[motor], self.robot.motor_rows[motor]
            linear = -float(self._linear.stiffness[gear, row])
            hard = gear == row or not linear > 0
            self._stiffenings[motor] = 1.0 if hard else _local_stiffness(self.robot, gear, self._states) / linear
        return self._stiffenings[motor]

    def _source(self, motor: int, entry: Entry) -> tuple[FloatArray, FloatArray]:
        """Return the input column G of the error dynamics and the feed-through D of an entry, computed once."""
        if (motor, entry) not in self._sources:
            self._sources[motor, entry] = self._new_source(motor, entry)
        return self._sources[motor, entry]

    def _new_source(self, motor: int, entry: Entry) -> tuple[FloatArray, FloatArray]:
        model, T, M = self._linear, self.data.record.sample_time, self.robot.n_motors
        n = len(model.mass)
        through = np.zeros(M)
        if entry == "encoder":
            through[motor] = 1.0
            return -self._step(T) @ self.data.gain.gain[:, motor], through
        row = self.robot.motor_rows[motor]
        force = -model.stiffness[:, row] if entry == "gear" else model.input[:, motor]
        column = np.concatenate([np.zeros(n), np.linalg.solve(model.mass, force)])
        half = self._step(T / 2)
        return half @ column * T, through

    def _step(self, time: float) -> FloatArray:
        A = self._linear.matrices()[0]
        transition: FloatArray = expm(A * time)
        return transition

    @property
    def _upper(self) -> list[tuple[int, float]]:
        """List the modes with weights; of a conjugate pair one, with weight 2."""
        return [
            (mode, 1.0 if value.imag == 0 else 2.0) for mode, value in enumerate(self._eigenvalues) if value.imag >= 0
        ]

    @cached_property
    def _readout(self) -> ComplexArray:
        C = self._linear.matrices()[2][: self.robot.n_motors]
        readout: ComplexArray = C @ self._modes
        return readout

    def _forward(self, source: tuple[FloatArray, FloatArray], disturbance: ComplexArray) -> ComplexArray:
        """Compute the prediction errors of a disturbance, of real and imaginary part apart, shape (n, M)."""
        n, M = self._residual.shape
        if len(self._upper) * M < MANY:
            parts = [self._filtered(source, part) for part in (disturbance.real, disturbance.imag)]
            return parts[0] + 1j * parts[1]
        spectrum = self._response(source)
        errors: ComplexArray = ifft(spectrum * fft(disturbance, len(spectrum))[:, None], axis=0)[:n]
        return errors

    def _disturbances(self, source: tuple[FloatArray, FloatArray]) -> Iterator[FloatArray]:
        """Yield the disturbance that the prediction errors suggest, shape (n,), for noise of several sizes."""
        n, spread = len(self._residual), self.data.spread
        known = np.isfinite(spread)
        weight = np.sqrt(
            np.mean(np.where(known, 1 / np.square(spread), 0.0), axis=0)
        )  # none of a motor that is left out
        response = self._response(source) * weight
        errors = fft(np.where(known, self._residual, 0.0), len(response), axis=0)
        matched, power = np.sum(response.conj() * errors, axis=1), np.sum(np.square(np.abs(response)), axis=1)
        for share in NOISE:
            yield ifft(matched / (power + share * power.max()))[:n].real

    def _response(self, source: tuple[FloatArray, FloatArray]) -> ComplexArray:
        """Return the spectrum of the prediction errors of an impulse, shape (at least 2 n, M)."""
        key = source[0].tobytes() + source[1].tobytes()
        if key not in self._spectra:
            while len(self._spectra) >= KEPT:
                self._spectra.pop(next(iter(self._spectra)))
            n = len(self._residual)
            impulse = np.zeros(n)
            impulse[0] = 1.0
            self._spectra[key] = fft(self._filtered(source, impulse), next_fast_len(2 * n), axis=0)
        return self._spectra[key]

    def _filtered(self, source: tuple[FloatArray, FloatArray], disturbance: FloatArray) -> FloatArray:
        """Compute the prediction errors of a disturbance mode by mode, shape (n, M)."""
        column, through = source
        entered = np.linalg.solve(self._modes, column.astype(complex))
        errors = np.outer(through, disturbance)
        for mode, weight in self._upper:
            pole = self._eigenvalues[mode]
            residues = weight * entered[mode] * self._readout[:, mode]
            denominator = [1.0, -pole.real] if pole.imag == 0 else [1.0, -2 * pole.real, abs(pole) ** 2]
            for motor, residue in enumerate(residues):  # of a mode and its conjugate together, which is real
                numerator = [0.0, residue.real, -(residue * pole.conjugate()).real][: len(denominator)]
                errors[motor] += lfilter(numerator, denominator, disturbance)
        return errors.T


def _with_mean_stiffness(robot: Robot, states: FloatArray) -> Robot:
    """Scale the springs that are not linear so that they have, at rest, their mean stiffness along a motion."""
    values = {}
    for index, joint in enumerate(robot.joints):
        spring = joint.direction.spring
        if isinstance(spring, Spring) and (spring.piecewise_linear is not None or spring.cubic is not None):
            along, name = _local_stiffness(robot, index, states), f"{joint.name}.stiffness"
            (at_rest,) = _local_stiffness(robot, index, np.zeros((1, states.shape[1])))
            if at_rest > 0:
                values[name] = robot.parameters[name].value * float(along.mean() / at_rest)
    return robot.with_values(values) if values else robot


def _local_stiffness(robot: Robot, index: int, states: FloatArray) -> FloatArray:
    """Evaluate the slope of a spring at the deflections of states [q, v], shape (n,)."""
    joint = robot.joints[index]
    spring, deflection = joint.direction.spring, ca.SX.sym("deflection")
    assert isinstance(spring, Spring)
    torque = spring.force(deflection, robot.parameters[f"{joint.name}.stiffness"].value)
    slope = ca.Function("slope", [deflection], [ca.jacobian(torque, deflection)])
    motor = joint.motor_coordinate
    deflections = (0.0 if motor is None else states[:, robot.n_arm + motor]) - states[:, index]
    return np.asarray(slope(np.abs(deflections)[None])).ravel()


def evenly(angle: FloatArray, highest: float) -> FloatArray:
    """Return weights by which no angle counts much more than most others [1], shape (n,).

    Args:
        angle: Rotor angle of every sample [rad], shape (n,).
        highest: Highest order [periods per turn].
    """
    cell = ((angle - angle.min()) * POINTS * highest / (2 * np.pi)).astype(int)
    number = np.bincount(cell)
    weights: FloatArray = np.minimum(1.0, MOST_AT_ONE * np.median(number[number > 0]) / number[cell])
    return weights


def angle_spectrum(signal: FloatArray, angle: FloatArray, highest: float) -> tuple[FloatArray, FloatArray]:
    """Evaluate |sum of signal exp(i n angle)| over orders n, with the samples interpolated to an even grid of angles.

    Args:
        signal: One value per sample, shape (n,).
        angle: Rotor angle of every sample [rad], shape (n,).
        highest: Highest order [periods per turn].

    Returns:
        Orders [periods per turn] and magnitudes, shape (n_orders,) each.
    """
    spacing = 2 * np.pi / (POINTS * highest)
    position = (angle - angle.min()) / spacing
    cell = position.astype(int)
    share = position - cell
    n_grid = int(cell.max()) + 2
    grid = np.bincount(cell, signal * (1 - share), n_grid) + np.bincount(cell + 1, signal * share, n_grid)
    padded = next_fast_len(PADDING * n_grid)
    score = np.abs(np.fft.rfft(grid, padded))
    orders = 2 * np.pi * np.arange(len(score)) / (padded * spacing)
    inside = orders <= highest
    return orders[inside], score[inside]
