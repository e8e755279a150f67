"""How late the torques of a log act, by the regression of all torques."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.fit.torques.solution import rest_of
from flexros.gap.settings import TorqueStartSettings

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.record.record import Record


def torque_delay(
    record: Record, model: RobotWithEffects, tolerance: Tolerance, settings: TorqueStartSettings | None = None
) -> float:
    """Return by how much the torques of a log act later than the model has it [s], in whole samples; 0 unless clear.

    Friction and inertia that are fitted to torques that act later are far off, and what is left of the torques is that
    delay. So one sample after the other is tried for as long as less is left, sum over the motors of ln(rms).

    Args:
        record: The log; of position commands the delay is found with the gains of the servos, not here.
        model: The nominal model, with no laws but Coulomb friction.
        tolerance: Parameters of the robot that may deviate.
        settings: Settings of the regression.
    """
    settings = settings or TorqueStartSettings()
    if record.command is not None or record.simulated or model.robot.flexible_motors:
        return 0.0
    left: list[float] = []
    for samples in range(settings.longest_delay + 1):
        found = regress_torque(record, model, tolerance, delay=samples * record.sample_time, settings=settings)
        if found is None:
            break
        left.append(rest_of(found))
        if left[-1] > min(left):
            break
    best = int(np.argmin(left)) if left else 0
    return best * record.sample_time if best and left[0] - left[best] > settings.late else 0.0
