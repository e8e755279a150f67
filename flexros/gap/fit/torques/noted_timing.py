"""When the noted torques of a log acted, as a model shows; see `flexros.identify.rigid.torque_timing` for rigid links.

A log of positions and torques does not say where in its sample a torque acted. Half a sample more or less looks like
viscous friction, for gravity changes with the position and acceleration with the torque. So it is sought before effects
are, and again beside those that were found. Commands that a recorder thins, or notes after they were held, acted
earlier than a command that is held from its stamp on; that they act later is a delay, and no matter of the recorder.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.pruning import own_information
from flexros.gap.fit.torques.arm_torque import arm_torque
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.fit.torques.solution import rest_of
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.rigid.torque_timing import CLEAR, in_time
from flexros.record.torques.shifted_torque import HELD, shifted, timing_is_open

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.record import Record
    from flexros.robot import Robot

DELAYED = CLEAR / 2
"""Further gain by a whole sample from which it is rather a delay [1] (chosen): springs that are far off leave much."""
SURE = 6.0
"""Twice the gain in log-likelihood beyond the penalty of one parameter, from which a shift counts [1] (chosen)."""
PARTS = 16
"""Parts of a log whose gains must agree [1] (chosen)."""
AGREED = 3.0
"""Mean gain of the parts over its standard deviation, from which they agree [1] (chosen): 4.2 and more in logs of
simulators that are not ours with thinned commands, 1.1 and less where a shift fits a log and predicts a second one
worse (two measured robots)."""
NEAR = 2.0
"""Mean squared error of a fit that is near enough to the floor for that; above, `CLEAR` counts [1] (chosen)."""


def with_torque_in_time_behind_springs(
    record: Record, robot: Robot, settings: DiagnosisSettings | None = None
) -> Record:
    """Return a record whose measured torques are taken when they acted, as far as the robot with its springs shows it.

    Springs that are far off, or backlash, leave so much that half a sample is hidden; then a fit shows it.

    Args:
        record: The log.
        robot: The nominal robot.
        settings: Settings of the diagnosis.
    """
    settings = settings or DiagnosisSettings()
    if not record.measured_torque or len(robot.flexible_motors) < robot.n_motors or not timing_is_open(record):
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
        return np.inf if found is None else rest_of(found)

    usual, half = left(0.0), {shift: left(shift) for shift in (-0.5, 0.5)}
    best = min(half, key=half.__getitem__)
    if not usual - half[best] > CLEAR or half[best] - left(2 * best) > DELAYED:
        return record
    return in_time(record, best)


def shift_of_noted(found: CandidateFit, null: NullFit, settings: DiagnosisSettings | None = None) -> float | None:
    """Return when noted torques acted, as a fit shows it; None where that is at their stamps, or not known.

    The hypothesis is fitted with torques that acted elsewhere in their sample, also without the effect that it needs
    least there, which may stand for that. Near the floor the better of these counts where n ln(V / V_shifted) exceeds
    ln n for each parameter that it has more, and 6, and the parts of the log agree; else where ln(V / V_shifted) / 2 >
    0.3. Another half a sample must leave more. A delay of measured torques may stand for half a sample: without it no
    more must be left.

    Args:
        found: The fit.
        null: The nominal model of the same log.
        settings: Settings of the diagnosis.

    Returns:
        Samples of the recorder from the stamp of a torque to the middle of the time in which it acts.
    """
    tried, record = _Shifts(found, null, settings or DiagnosisSettings()), null.data.record
    delays = {candidate.name for candidate in found.hypothesis if candidate.effect.delays_commands}
    commands = not record.measured_torque
    if not timing_is_open(record) or (commands and delays):
        return None
    fits = {shift: tried.fitted(shift, delays) for shift in ((0.0, -HELD) if commands else (-HELD, HELD))}
    best = min(fits, key=lambda shift: fits[shift].chi2)
    least = fits[best].chi2
    beyond = best + (HELD if best > 0 else -HELD)
    if least >= found.chi2 or least >= (fits.get(beyond) or tried.fitted(beyond, delays)).chi2:
        return None
    if delays:
        return best
    usual = tried.fitted(record.torque_shift, delays)
    if usual.chi2 > NEAR * null.data.n_values:
        return best if least < np.exp(-2 * CLEAR) * usual.chi2 else None
    clear = tried.is_clear(usual, fits[best], best) or tried.is_clear_without_one(usual, fits[best], best)
    return best if clear else None


class _Shifts:
    """Fits of a hypothesis to a log with torques that acted elsewhere in their sample."""

    def __init__(self, found: CandidateFit, null: NullFit, settings: DiagnosisSettings) -> None:
        self._found, self._null, self._settings = found, null, settings

    def is_clear(self, usual: CandidateFit, fit: CandidateFit, shift: float, penalty: float = 0.0) -> bool:
        """Return whether a fit at a shift is more likely than the usual one, and the parts of the log agree.

        Args:
            usual: The fit at the stamps.
            fit: The fit at the shift.
            shift: The shift [samples].
            penalty: Penalty of the parameters that it has less [1].
        """
        if self._gain(usual.chi2, fit.chi2) + penalty <= self._needed:
            return False
        data = self._null.data
        moved = _moved(data, shift)
        before, after = (
            data.squares_in_time(usual.residual(data), PARTS),
            moved.squares_in_time(fit.residual(moved), PARTS),
        )
        gains = before - after + penalty / PARTS
        return bool(gains.mean() > AGREED * gains.std(ddof=1) / np.sqrt(PARTS))

    def is_clear_without_one(self, usual: CandidateFit, fit: CandidateFit, shift: float) -> bool:
        """Return whether it is so without the effect that a fit needs least."""
        cost = {name: self._gain(rest, fit.chi2) - self._penalty(name) for name, rest in _without_each(fit).items()}
        if not cost or self._gain(usual.chi2, fit.chi2) - min(cost.values()) <= self._needed:
            return False
        least = min(cost, key=cost.__getitem__)
        return self.is_clear(usual, self.fitted(shift, {least}), shift, self._penalty(least))

    @property
    def _needed(self) -> float:
        """Twice the gain in log-likelihood that a shift needs."""
        return float(np.log(self._null.data.n_values)) + SURE

    def _gain(self, usual: float, chi2: float) -> float:
        return self._null.data.n_values * float(np.log(usual / chi2))

    def _penalty(self, name: str) -> float:
        return float(self._found.columns([name]).sum() * np.log(self._null.data.n_values))

    def fitted(self, shift: float, without: Collection[str]) -> CandidateFit:
        """Fit the hypothesis without some candidates."""
        found, data, settings = self._found, self._null.data, self._settings
        chosen = tuple(candidate for candidate in found.hypothesis if candidate.name not in without)
        predictor = found.predictor if len(chosen) == len(found.hypothesis) else self._null.predictor(chosen)
        start, enough = found.theta[~found.columns(without)], max(settings.fit.enough, data.negligible)
        moved = _moved(data, shift)
        return fit(predictor, moved, start, settings.fit.joint_iterations, enough=enough, settings=settings.fit)


def _without_each(fit: CandidateFit) -> dict[str, float]:
    """Estimate the sum of squares without each effect that has one parameter (Wald 1943)."""
    left = {}
    for candidate in fit.hypothesis if len(fit.information) else ():
        neutral = [candidate.neutral(free) for free in candidate.free]
        if len(neutral) == 1 and neutral[0] is not None:
            at = int(np.flatnonzero(fit.columns([candidate.name]))[0])
            left[candidate.name] = fit.chi2 + (fit.theta[at] - neutral[0]) ** 2 * own_information(fit.information, at)
    return left


def _moved(data: FitData, shift: float) -> FitData:
    """Return a log whose torques acted elsewhere in their sample."""
    record, torques = shifted(data.record, shift), data.torques
    later = (shift - data.record.torque_shift) * record.sample_time / record.recorder_samples
    return replace(data, record=record, torques=None if torques is None else torques.acting_later(later))
