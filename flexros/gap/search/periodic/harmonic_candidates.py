"""Candidates that repeat with the angle of a rotor, with orders found in the prediction errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.fit.directions import changes_of
from flexros.gap.fit.least_norm import least_norm
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.search.periodic.harmonics import SEARCH, VALLEYS, OrderSearch

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.periodic.harmonics import HarmonicFit
    from flexros.gap.settings import SearchSettings
    from flexros.robot import Robot


FINE = 1e-3
"""Step of the derivative to an order over the usual one [1] (chosen): the usual one, a thousandth of the order, turns
the phase at the end of a motion of hundreds of rad of the rotor by more than a radian."""
AROUND = 3.0
"""Factor by which an order may move from its initial values (chosen): while much is missing, few turns in the motion
of an arm give it no better."""
TURNS = 4
"""Turns to each side by which a phase may move (chosen): it is that at position zero, where the motion may never be,
and moves far with the order."""


def harmonic_candidates(
    robot: Robot,
    data: FitData,
    residual: FloatArray,
    states: FloatArray,
    settings: SearchSettings,
) -> tuple[Candidate, ...]:
    """List the effects with a harmonic at every motor, with the orders that fit best.

    The search for orders is linear, but nonlinear robots may rank the orders in another way. So many orders are tried,
    and with every effect the best order of each other one.

    Args:
        robot: The nominal robot.
        data: Log and weights.
        residual: Weighted prediction errors that are to be explained, shape (n_values,).
        states: Predicted states [q, v], shape (n, n_states).
        settings: Settings of the search for orders.

    Returns:
        Candidates with an initial value per harmonic.
    """
    search = OrderSearch(robot, data, residual, states, data.pose, settings)
    every = [(effect, way) for effect in effects().values() for way in effect.harmonics]
    own = LANES - len(every) + 1
    candidates: list[Candidate] = []
    for motor, location in enumerate(robot.joint_names):
        here = [(effect, way) for effect, way in every if location in effect().locations(robot)]
        harmonics = [search.search(motor, way.entry, own) for _, way in here]
        for index, (effect, way) in enumerate(here):
            others = [rest[0].order for rest in harmonics[:index] + harmonics[index + 1 :] if rest]
            together = (*harmonics[index], *(search.fit(motor, way.entry, order) for order in others))
            if together:
                free = _free(together, way.largest, search.least(motor))
                candidates.append(Candidate(effect, location, free, way.fixed, together=True))
    return tuple(candidates)


def harmonics_in_place(
    fit: CandidateFit, replaced: Candidate, data: FitData, settings: SearchSettings = SEARCH
) -> tuple[Candidate, ...]:
    """List the other effects with a harmonic at the motor of one of a fit, of its order, for the errors without it.

    Which effect has the order of a rotor is found while much else is still missing, and may be wrong.

    Args:
        fit: The fit.
        replaced: One of its effects, with a harmonic.
        data: Log and weights.
        settings: Settings of the search for orders.

    Returns:
        Candidates with one initial value each; none in place of an effect that has no order.
    """
    values = dict(zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True))[replaced]
    if "order" not in values:  # where its parameters were pruned
        return ()
    robot = fit.predictor.robot
    off = data.residuals(fit.predictor, fit.switched_off((replaced.name,))[:, None])[:, 0]
    search = OrderSearch(robot, data, off, fit.states(data), data.pose, settings)
    motor, found = robot.joint_names.index(replaced.location), []
    for effect in effects().values():
        if effect is replaced.effect or replaced.location not in effect().locations(robot):
            continue
        for way in effect.harmonics:
            harmonic = search.fit(motor, way.entry, values["order"])
            free = _free((harmonic,), way.largest)
            found.append(Candidate(effect, replaced.location, free, way.fixed, together=True))
    return tuple(found)


def neighbouring_orders(fit: CandidateFit, data: FitData, rows: IntArray) -> FloatArray:
    """List initial values with orders near those of a fit: its sum of squares has a valley per turn of the log.

    Args:
        fit: The fit.
        data: Log and weights.
        rows: Prediction errors that count, shape (n_rows,).

    Returns:
        Initial values in the units of the fit, those that promise most first, shape (n_fitted, n_starts); none without
        a harmonic.
    """
    begin, found = 0, []
    for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True):
        if "order" in values and candidate.effect.harmonics:
            found += _Neighbours(fit, data, rows, candidate, begin).by_least_squares(values)
        begin += len(candidate.free)
    found.sort(key=lambda pair: pair[0])
    return np.array([start for _, start in found]).reshape(len(found), len(fit.theta)).T


@dataclass(frozen=True, eq=False)
class _Neighbours:
    """Orders near that of one harmonic of a fit, whose other effects stay as they are.

    Attributes:
        fit: The fit.
        data: Log and weights.
        rows: Prediction errors that count, shape (n_rows,).
        candidate: The effect with the harmonic.
        begin: Place of its first parameter in the fit.
    """

    fit: CandidateFit
    data: FitData
    rows: IntArray
    candidate: Candidate
    begin: int

    def by_least_squares(self, values: Mapping[str, float]) -> list[tuple[float, FloatArray]]:
        """Fit amplitude and phase of each order to the changes of the errors by its sine and its cosine.

        Args:
            values: Amplitude, order and phase in the fit.

        Returns:
            Of each order the sum of squares that is left [1], and initial values, shape (n_fitted,); none of an order
            whose prediction diverges.
        """
        robot, record = self.fit.predictor.robot, self.data.record
        motor = robot.joint_names.index(self.candidate.location)
        angle = robot.rotor_turns[motor] * record.position[record.valid, motor]
        middle, valley = float(np.mean(angle)), np.pi / max(float(np.ptp(angle)), 1e-12)
        orders = [order for order in values["order"] + valley * VALLEYS if order > 0]
        phases = [values["phase"] + (values["order"] - order) * middle for order in orders]  # as it is in the middle
        pairs = list(zip(orders, phases))
        waves = [self._theta(order=n, phase=p + quarter) for n, p in pairs for quarter in (0.0, np.pi / 2)]
        off, residual = self.fit.switched_off((self.candidate.name,)), self.fit.residual(self.data)
        changes = changes_of(self.fit, self.data, residual, self.rows, np.stack([off, *waves], axis=-1))
        rest, changes = residual[self.rows] + changes[:, 0], changes[:, 1:] - changes[:, :1]
        found = []
        for index, (order, phase) in enumerate(pairs):
            X = changes[:, 2 * index : 2 * index + 2]
            if not np.isfinite([X.sum(), rest.sum()]).all():
                continue
            wave = least_norm(X.T @ X, -X.T @ rest)
            amplitude, lead = values["amplitude"] * float(np.hypot(*wave)), float(np.arctan2(wave[1], wave[0]))
            left = float(np.sum((rest + X @ wave) ** 2))
            found.append((left, self._theta(amplitude=amplitude, order=order, phase=phase + lead)))
        return found

    def _theta(self, **changed: float) -> FloatArray:
        """Return the parameters of the fit with some values of the harmonic changed; phases within half a turn."""
        theta = self.fit.theta.copy()
        for place, free in enumerate(self.candidate.free, self.begin):
            if free.name in changed:
                value = changed[free.name]
                if free.name == "phase":  # far from the limits of its search
                    value = float(np.remainder(value + np.pi, 2 * np.pi) - np.pi)
                theta[place] = np.clip(free.encode(value), *free.bounds)
        return theta


def _free(harmonics: Sequence[HarmonicFit], most: float, lowest: float = 0.0) -> tuple[FreeParameter, ...]:
    amplitudes = tuple(min(max(harmonic.amplitude, 1e-15), most) for harmonic in harmonics)
    orders, phases = tuple(harmonic.order for harmonic in harmonics), tuple(harmonic.phase for harmonic in harmonics)
    high = min(max(amplitudes) * 1e4, most)
    low = min(max(min(orders) / AROUND, lowest), min(orders))
    return (
        FreeParameter("amplitude", min(amplitudes) * 1e-4, high, signed=False, starts=amplitudes),
        FreeParameter("order", low, max(orders) * AROUND, signed=False, starts=orders, fine=FINE),
        FreeParameter("phase", 0.0, TURNS * 2 * np.pi, signed=True, starts=phases, fine=1.0 / TURNS),
    )
