"""Regression of torques beside those over the position of a motor: of a counterbalance, a cable or a hose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.counterbalance import Counterbalance
from flexros.gap.fit.torques.position_torque import PositionTorque, curve_of
from flexros.gap.fit.torques.regression import prepared_regression

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.torques.arm_torque import ArmTorque
    from flexros.gap.fit.torques.regression import PreparedRegression
    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.record.record import Record


def regress_balanced(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    arm: ArmTorque | None = None,
    *,
    delay: float = 0.0,
    settings: TorqueStartSettings,
) -> TorqueRegression | None:
    """Regress the torques, with torques over the position of every motor at which one explains much.

    Without it, friction, rotor and bodies stand for it. A spring or a gas cylinder carries the weight of many heavy
    arms, and cables and hoses pull at wrists.

    Args:
        record: The log.
        model: The nominal model, with no laws but Coulomb friction.
        tolerance: Parameters of the robot that may deviate.
        arm: What the arm takes from the motors; None for locked springs.
        delay: Delay of the commands beyond that of the model [s].
        settings: Settings of the regression.

    Returns:
        The regression; None where there is none without these.
    """
    prepared = prepared_regression(record, model, tolerance, arm, delay=delay, settings=settings)
    found = None if prepared is None else prepared.solved()
    while prepared is not None and found is not None:
        better = _with_another(found, prepared, record, model, settings)
        if better is None:
            break
        found = better
    return found


def _with_another(
    before: TorqueRegression,
    prepared: PreparedRegression,
    record: Record,
    model: RobotWithEffects,
    settings: TorqueStartSettings,
) -> TorqueRegression | None:
    """Return a regression with a torque over position at the motor at which it explains most; None where none does.

    A curve must explain as much more than a counterbalance as that explains itself. A counterbalance that carries less
    leaves little less of the torque, where masses and centres of the links stand for it far out of their tolerance: it
    is there where it takes most of that back.
    """
    known, turning = before.position_torques, Counterbalance().locations(model.robot)
    best, most, relieving, least = None, settings.balanced, None, settings.least_taken_back
    for motor, name in enumerate(model.robot.joint_names):
        if not record.predicted[motor] or any(one.motor == motor for one in known):
            continue
        largest = np.nanmax(np.abs(record.torque[:, motor]))
        left, carried = before.rest[motor], settings.carried * largest
        for torque in (*([PositionTorque(motor)] if name in turning else []), curve_of(record, motor)):
            found = prepared.solved((*known, torque))
            if found is None:
                continue
            lowered, left = left > settings.balanced * found.rest[motor], min(left, found.rest[motor])
            factor, amplitude = before.rest[motor] / found.rest[motor], found.position_torques[-1].amplitude
            if lowered and factor > most and amplitude >= carried:
                best, most = found, factor
            relieved = _strain(before) - _strain(found)
            carries = settings.carried_little * largest <= amplitude <= largest
            helps = torque.span is None and factor > 1.0 and carries
            if helps and relieved > max(least, settings.taken_back * _strain(before)):
                relieving, least = found, relieved
    return best or relieving


def _strain(regression: TorqueRegression) -> float:
    """Return how far a regression moves tolerated numbers, as the sum of their squared deviations [1]."""
    return float(np.sum(regression.deviations**2))
