"""Candidates that repeat with the angle of a rotor, with orders found in the prediction errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.search.harmonics import SEARCH, OrderSearch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.harmonics import HarmonicFit
    from flexros.gap.settings import SearchSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

VALLEYS = np.array([index for index in range(-8, 9) if index])
"""Neighbours of an order that are tried as well, in half turns over the travel of the rotor in a log [1]."""


def harmonic_candidates(
    robot: Robot,
    data: FitData,
    residual: FloatArray,
    states: FloatArray,
    settings: SearchSettings = SEARCH,
    starts: int = LANES,
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
        starts: Initial values per candidate.

    Returns:
        Candidates with an initial value per harmonic.
    """
    search = OrderSearch(robot, data, residual, states, data.pose, settings)
    every = [(effect, way) for effect in effects().values() for way in effect.harmonics]
    own = starts - len(every) + 1
    candidates: list[Candidate] = []
    for motor, location in enumerate(robot.joint_names):
        here = [(effect, way) for effect, way in every if location in effect().locations(robot)]
        harmonics = [search.search(motor, way.entry, own) for _, way in here]
        for index, (effect, way) in enumerate(here):
            others = [rest[0].order for rest in harmonics[:index] + harmonics[index + 1 :] if rest]
            together = (*harmonics[index], *(search.fit(motor, way.entry, order) for order in others))
            if together:
                free = _free(together, way.largest)
                candidates.append(Candidate(effect, location, free, way.fixed, together=True))
    return tuple(candidates)


def neighbouring_orders(fit: CandidateFit, record: Record) -> FloatArray:
    """List initial values with orders near those of a fit: its sum of squares has a valley per turn of the log.

    The phase follows, so that the harmonic in the middle of the motion stays the same, or changes its sign and so stays
    nearly the same at both ends.

    Args:
        fit: The fit.
        record: The log.

    Returns:
        Initial values in the units of the fit, shape (n_fitted, n_starts); none without a harmonic.
    """
    robot, begin, starts = fit.predictor.robot, 0, []
    for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta)):
        names = [free.name for free in candidate.free]
        if "order" in names:
            motor = robot.joint_names.index(candidate.location)
            angle = robot.rotor_turns[motor] * record.position[record.valid, motor]
            middle, valley = float(np.mean(angle)), np.pi / max(float(np.ptp(angle)), 1e-12)
            for order in values["order"] + valley * VALLEYS:
                for turn in (0.0, np.pi) if order > 0 else ():
                    phase = values["phase"] + turn + (values["order"] - order) * middle
                    theta = fit.theta.copy()
                    for name, value in (("order", order), ("phase", np.remainder(phase, 2 * np.pi))):
                        theta[begin + names.index(name)] = candidate.free[names.index(name)].encode(value)
                    starts.append(theta)
        begin += len(names)
    return np.array(starts).reshape(-1, len(fit.theta)).T


def _free(harmonics: Sequence[HarmonicFit], most: float) -> tuple[FreeParameter, ...]:
    amplitudes = tuple(min(max(harmonic.amplitude, 1e-15), most) for harmonic in harmonics)
    orders, phases = tuple(harmonic.order for harmonic in harmonics), tuple(harmonic.phase for harmonic in harmonics)
    high = min(max(amplitudes) * 1e4, most)
    return (
        FreeParameter("amplitude", min(amplitudes) * 1e-4, high, signed=False, starts=amplitudes),
        FreeParameter("order", min(orders) / 1.5, max(orders) * 1.5, signed=False, starts=orders),
        FreeParameter("phase", 0.0, 2 * np.pi, signed=True, starts=phases),
    )
