"""Regression of torques beside those over the position of a motor: of a counterbalance, a cable or a hose."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.counterbalance import Counterbalance
from flexros.gap.fit.torques.position_torque import PositionTorque, curve_of
from flexros.gap.fit.torques.regression import prepared_regression
from flexros.gap.fit.torques.rough_bodies import with_rough_bodies

if TYPE_CHECKING:
    from collections.abc import Callable

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

    def prepare(allowed: Tolerance) -> PreparedRegression | None:
        return prepared_regression(record, model, allowed, arm, delay=delay, settings=settings)

    prepared, rough = prepare(tolerance), partial(prepare, with_rough_bodies(tolerance, settings.rough_bodies))
    found = None if prepared is None else prepared.solved()
    while prepared is not None and found is not None:
        better = _with_another(found, prepared, record, model, settings)
        better = better or _relieving(found, prepared, rough, record, model, settings)
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

    A curve must explain as much more than a counterbalance as that explains itself.
    """
    known, turning = before.position_torques, Counterbalance().locations(model.robot)
    best, most = None, settings.balanced
    for motor, name in enumerate(model.robot.joint_names):
        if not record.predicted[motor] or any(one.motor == motor for one in known):
            continue
        left, carried = before.rest[motor], settings.carried * _largest(record, motor)
        for torque in (*([PositionTorque(motor)] if name in turning else []), curve_of(record, motor)):
            found = prepared.solved((*known, torque))
            if found is None:
                continue
            lowered, left = left > settings.balanced * found.rest[motor], min(left, found.rest[motor])
            factor = before.rest[motor] / found.rest[motor]
            if lowered and factor > most and found.position_torques[-1].amplitude >= carried:
                best, most = found, factor
    return best


def _relieving(
    before: TorqueRegression,
    prepared: PreparedRegression,
    rough: Callable[[], PreparedRegression | None],
    record: Record,
    model: RobotWithEffects,
    settings: TorqueStartSettings,
) -> TorqueRegression | None:
    """Return a regression with a counterbalance that takes numbers of the links back within their tolerance.

    One that carries less than others leaves little less of the torque, as masses and centres far out of their tolerance
    stand for it. These may be wrong as well: then links that may be farther off leave less without it.

    Args:
        before: The regression without it.
        prepared: The same, not solved.
        rough: Prepares one with rough numbers of the links.
        record: The log.
        model: The nominal model.
        settings: Settings of the regression.

    Returns:
        The regression; None without such a counterbalance.
    """
    known, strain = before.position_torques, _strain(before)
    best, least = None, max(settings.least_taken_back, settings.taken_back * strain)
    if strain < least:
        return None
    for name in Counterbalance().locations(model.robot):
        motor = model.robot.joint_names.index(name)
        if not record.predicted[motor] or any(one.motor == motor for one in known):
            continue
        found, largest = prepared.solved((*known, PositionTorque(motor))), _largest(record, motor)
        if found is None or found.rest[motor] >= before.rest[motor] or strain - _strain(found) <= least:
            continue
        if settings.carried_little * largest <= found.position_torques[-1].amplitude <= largest:
            best, least = found, strain - _strain(found)
    farther = None if best is None else rough()
    without = None if farther is None else farther.solved(known)
    if best is None or without is None:
        return best
    motor = best.position_torques[-1].motor
    return best if best.rest[motor] <= without.rest[motor] else None


def _largest(record: Record, motor: int) -> float:
    """Return the largest torque of a motor in a log [Nm or N]."""
    return float(np.nanmax(np.abs(record.torque[:, motor])))


def _strain(regression: TorqueRegression) -> float:
    """Return how far a regression moves tolerated numbers, as the sum of their squared deviations [1]."""
    return float(np.sum(regression.deviations**2))
