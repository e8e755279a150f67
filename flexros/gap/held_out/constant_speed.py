"""Motors that a repaired model predicts hardly better than if they moved on at constant speed.

A far too large inertia makes torques act hardly at all: where the nominal model lacks the friction that balances them,
it closes nearly the whole gap, and says nothing of the robot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.gap.held_out.errors_ahead import HORIZON, samples_ahead

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.robot import Robot

HEAVIER = 3.0
"""Inertia at a motor over the nominal one from which torques may hardly act [1] (chosen)."""
HARDLY = 0.5
"""Errors of a motor over those at constant speed from which a model predicts hardly better [1] (chosen): friction of a
servo motor that was missing had 0.37, an inertia of 900 times its value 0.99."""
MOST = 0.8
"""Share of what a repair closes at a motor from which most of it is closed at constant speed as well [1] (chosen)."""


def moving_on(fit: CandidateFit, nominal: Robot, data: FitData, before: AheadErrors, after: AheadErrors) -> list[str]:
    """List the motors that a much larger inertia moves on at about constant speed, which closes most of their gap.

    A rotor that the robot file leaves out has no nominal size, and is much larger than bodies alone may be.

    Args:
        fit: The repaired model.
        nominal: The nominal robot, as it was given.
        data: The log.
        before: Errors of the nominal model in it.
        after: Those of the repaired model.
    """
    stated = np.array([nominal.parameters[f"{name}.inertia"].value > 0 for name in nominal.joint_names])
    if not stated.any():
        return []
    given = inertias_of_bodies(data.record, nominal)
    now = inertias_of_bodies(data.record, fit.predictor.robot, fit.predictor.numbers(fit.theta))
    heavier = stated & np.array([now[name] > HEAVIER * given[name] for name in nominal.joint_names])
    if not heavier.any():
        return []
    constant = constant_speed_errors(fit.predictor, fit.theta, data, after)
    found = []
    for motor in np.flatnonzero(heavier):
        for signal in after.of_motor(int(motor)):
            first, left, alike = before.rms(signal) ** 2, after.rms(signal) ** 2, float(constant[motor]) ** 2
            gap = first - left > after.floor[signal] ** 2
            if gap and left > HARDLY**2 * alike and first - alike > MOST * (first - left):
                found.append(nominal.joint_names[motor])
    return found


def constant_speed_errors(predictor: Predictor, theta: FloatArray, data: FitData, errors: AheadErrors) -> FloatArray:
    """Return the errors of the motors 0.1 s ahead if each moved on at its speed, rms, shape (M,) [rad or m].

    Their positions and speeds are those that the predictor has at the start, from the log up to there.

    Args:
        predictor: Predictor of the model.
        theta: Parameters in the units of the fit, shape (n_fitted,).
        data: The log.
        errors: Errors of the model, whose windows are taken.
    """
    record, robot, starts = data.record, predictor.robot, errors.starts
    prediction = data.predict(predictor, theta[:, None], record_states=True)
    assert prediction.states is not None
    states = prediction.states[:, :, 0]
    position = predictor.ahead(theta, record, states, starts, 0).positions
    speed = states[starts][:, [robot.n_coordinates + row for row in robot.motor_rows]]
    horizon = samples_ahead(record.sample_time)
    missed = record.position[starts + horizon] - position - horizon * record.sample_time * speed
    return np.asarray(np.sqrt(np.mean(missed**2, axis=0)))


def moving_on_words(motors: Sequence[str]) -> list[str]:
    """Say which motors are predicted as if they moved on; nothing where none is.

    Args:
        motors: Their names.
    """
    if not motors:
        return []
    several = len(motors) > 1
    return [
        f"{', '.join(motors)} {'are' if several else 'is'} predicted {HORIZON:g} s ahead hardly better than if "
        f"{'they' if several else 'it'} moved on at constant speed: an inertia that is far too large does that, as "
        "torques then hardly act. The share that is closed says little, and friction or a bias of the torques may be "
        "missing"
    ]
