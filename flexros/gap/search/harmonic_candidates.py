"""Candidates that repeat with the turning of a rotor, with orders found in the prediction errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.prediction.predictor import LANES
from flexros.gap.search.harmonics import OrderSearch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.harmonics import PeriodicFit
    from flexros.record.record import Record
    from flexros.robot import Robot

VALLEYS = np.array([place for place in range(-8, 9) if place])
"""Neighbours of an order that are tried as well, in half turns over the way of the rotor in a log [1] (chosen)."""


def harmonic_candidates(
    robot: Robot, data: FitData, residual: FloatArray, states: FloatArray, number: int = LANES
) -> tuple[Candidate, ...]:
    """List periodic effects at every motor with the orders that fit best.

    The search for orders is linear, so that nonlinear robots rank the orders otherwise: many are tried, and with every
    effect the best order of each other one.

    Args:
        robot: The nominal robot.
        data: Log and weights.
        residual: Weighted prediction errors that are to be explained, shape (M n,).
        states: Predicted states [q, v], shape (n, n_states).
        number: Orders per effect and motor.

    Returns:
        Candidates, each with a start per wave.
    """
    search = OrderSearch(robot, data, residual, states, data.pose)
    every = [(effect, way) for effect in effects().values() for way in effect.harmonics]
    own = number - len(every) + 1
    found: list[Candidate] = []
    for motor, location in enumerate(robot.joint_names):
        here = [(effect, way) for effect, way in every if location in effect().locations(robot)]
        waves = [search.search(motor, way.entry, own) for _, way in here]
        for index, (effect, way) in enumerate(here):
            others = [rest[0].order for rest in waves[:index] + waves[index + 1 :] if rest]
            together = (*waves[index], *(search.fit(motor, way.entry, order) for order in others))
            if together:
                free = _free(together, way.largest)
                found.append(Candidate(effect, location, free, way.fixed, together=True))
    return tuple(found)


def other_orders(one: CandidateFit, record: Record) -> FloatArray:
    """List starts with other orders near those of a fit: its sum of squares has a valley per turn that the log covers.

    The phase goes along, so that the wave in the middle of the motion stays the same, or turns into its opposite and
    so stays nearly the same at both ends.

    Args:
        one: The fit.
        record: The log.

    Returns:
        Numbers to start from, shape (n_fitted, starts); none without a periodic effect.
    """
    robot, first, starts = one.predictor.robot, 0, []
    for candidate, values in zip(one.predictor.hypothesis, one.predictor.values(one.theta)):
        names = [free.name for free in candidate.free]
        if "order" in names:
            motor = robot.joint_names.index(candidate.location)
            angle = robot.rotor_turns[motor] * record.position[record.valid, motor]
            middle, valley = float(np.mean(angle)), np.pi / max(float(np.ptp(angle)), 1e-12)
            for order in values["order"] + valley * VALLEYS:
                for turn in (0.0, np.pi) if order > 0 else ():
                    phase = values["phase"] + turn + (values["order"] - order) * middle
                    theta = one.theta.copy()
                    for name, value in (("order", order), ("phase", np.remainder(phase, 2 * np.pi))):
                        theta[first + names.index(name)] = candidate.free[names.index(name)].encode(value)
                    starts.append(theta)
        first += len(names)
    return np.array(starts).reshape(-1, len(one.theta)).T


def _free(waves: Sequence[PeriodicFit], most: float) -> tuple[FreeParameter, ...]:
    amplitudes = tuple(min(max(wave.amplitude, 1e-15), most) for wave in waves)
    orders, phases = tuple(wave.order for wave in waves), tuple(wave.phase for wave in waves)
    high = min(max(amplitudes) * 1e4, most)
    return (
        FreeParameter("amplitude", min(amplitudes) * 1e-4, high, signed=False, starts=amplitudes),
        FreeParameter("order", min(orders) / 1.5, max(orders) * 1.5, signed=False, starts=orders),
        FreeParameter("phase", 0.0, 2 * np.pi, signed=True, starts=phases),
    )
