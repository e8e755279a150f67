"""When a measured torque acted on robots with springs; see `flexros.identify.rigid.torque_timing` for rigid ones.

The torques themselves show it where the springs are nearly right. Where they are far off, or a gear has backlash, what
that leaves hides half a sample. Then the explanation of the log shows it: with its effects in place half a sample is
most of what is left.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.arm_torque import arm_torque
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.torque_regression import regress_torque
from flexros.gap.residuals.fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.rigid.torque_timing import CLEAR, in_time
from flexros.record.shifted_torque import shifted

if TYPE_CHECKING:
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.record.record import Record
    from flexros.robot import Robot

DELAY = "delay@all"
"""Delay of all motors, which half a sample looks like."""
DELAYED = CLEAR / 2
"""Further gain by a whole sample from which it is rather a delay [1] (chosen): springs that are far off leave much."""


def with_torque_in_time_behind_springs(
    record: Record, robot: Robot, settings: DiagnosisSettings | None = None
) -> Record:
    """Return a record whose measured torques are taken when they acted, as far as the robot with its springs shows it.

    Args:
        record: The log.
        robot: The nominal robot.
        settings: Settings of the diagnosis.
    """
    settings = settings or DiagnosisSettings()
    if not _unknown(record, robot):
        return record
    model, tolerance = RobotWithEffects(robot, ()), tolerance_of(robot, {}, record.prescribed)
    try:
        data = fit_data(record, model, settings)
    except InputError:
        return record

    def left(shift: float) -> float:
        """Sum the logarithms of what the model leaves of the torques."""
        part = shifted(data.record, shift)
        arm = arm_torque(replace(data, record=part), model, tolerance)
        found = regress_torque(part, model, tolerance, arm, settings=settings.torque_start)
        return np.inf if found is None else float(np.log(np.maximum(found.rest, 1e-300)).sum())

    usual, half = left(0.0), {shift: left(shift) for shift in (-0.5, 0.5)}
    best = min(half, key=half.__getitem__)
    if not usual - half[best] > CLEAR or half[best] - left(2 * best) > DELAYED:
        return record
    return in_time(record, best)


def shift_of_explanation(found: CandidateFit, null: NullFit, settings: DiagnosisSettings | None = None) -> float:
    """Return by how much measured torques act later than noted, as an explanation shows it: 0 or half a sample.

    It is fitted to the log with torques that act half a sample earlier and later, and counts where it leaves clearly
    less, ln(V / V_shifted) / 2 > 0.3, and a whole sample leaves more. A delay of half a sample in the explanation may
    stand for that: without it no more must be left.

    Args:
        found: The explanation, or a repaired model.
        null: The nominal model of the same log.
        settings: Settings of the diagnosis.

    Returns:
        Samples from the stamp of a torque to the middle of the time in which it acts: -0.5, 0 or 0.5.
    """
    settings, data = settings or DiagnosisSettings(), null.data
    if not _unknown(data.record, null.model.robot):
        return 0.0
    punctual = tuple(candidate for candidate in found.hypothesis if candidate.name != DELAY)
    kept = ~found.columns([DELAY])

    def left(shift: float) -> float:
        """Return the sum of squares that the explanation without delay of all motors leaves."""
        moved = replace(data, record=shifted(data.record, shift))
        predictor = found.predictor if len(punctual) == len(found.hypothesis) else null.predictor(punctual)
        enough = max(settings.fit.enough, data.negligible)
        start, iterations = found.theta[kept], settings.fit.joint_iterations
        return fit(predictor, moved, start, iterations, enough=enough, settings=settings.fit).chi2

    half = {shift: left(shift) for shift in (-0.5, 0.5)}
    best = min(half, key=half.__getitem__)
    most = found.chi2 * (np.exp(-2 * CLEAR) if kept.all() else 1.0)
    return best if half[best] < most and half[best] < left(2 * best) else 0.0


def _unknown(record: Record, robot: Robot) -> bool:
    """Return whether torques of a robot with springs were measured, and nothing is known of when they acted."""
    effort = record.effort
    if record.torque_shift or len(robot.flexible_motors) < robot.n_motors:
        return False
    measured = record.measured_torque and record.imported
    return measured and effort is not None and bool(np.isfinite(effort).all())
