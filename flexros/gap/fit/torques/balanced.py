"""Regression of torques beside a counterbalance, where one motor shows that it has one."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.counterbalance import Counterbalance
from flexros.gap.fit.torques.regression import regress_torque

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.torques.arm_torque import ArmTorque
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
    """Regress the torques, with a counterbalance at the motor at which it explains most, if that is much.

    Without it, friction, rotor and bodies stand for it.

    Args:
        record: The log.
        model: The nominal model, with no laws but Coulomb friction.
        tolerance: Parameters of the robot that may deviate.
        arm: What the arm takes from the motors; None for locked springs.
        delay: Delay of the commands beyond that of the model [s].
        settings: Settings of the regression.

    Returns:
        The regression; None where there is none without a counterbalance.
    """
    regress = partial(regress_torque, record, model, tolerance, arm, delay=delay, settings=settings)
    plain = regress()
    if plain is None:
        return None
    best = plain
    factor = settings.balanced
    for location in Counterbalance().locations(model.robot):
        motor = model.robot.joint_names.index(location)
        found = regress(balanced=motor)
        least = settings.carried * np.nanmax(np.abs(record.torque[:, motor]))
        if found is None or np.linalg.norm(found.balance[motor]) < least:
            continue
        if plain.rest[motor] > factor * found.rest[motor]:
            best, factor = found, plain.rest[motor] / found.rest[motor]
    return best
