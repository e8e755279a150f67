"""When the noted torques of a log acted, as a fit of it shows.

A log of positions and torques does not say where in its sample a torque acted. Half a sample more or less looks like
viscous friction, for gravity changes with the position and acceleration with the torque. So it is sought before effects
are, and again beside those that were found. Commands that a recorder thins, or notes after they were held, acted
earlier than a command that is held from its stamp on; that they act later is a delay, and no matter of the recorder.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.least_squares import fit
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.rigid.torque_timing import CLEAR
from flexros.record.shifted_torque import HELD, shifted, timing_is_open

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.residuals.fit_data import FitData

SURE = 6.0
"""Twice the gain in log-likelihood beyond the penalty of one parameter, from which a shift counts [1] (chosen)."""
NEAR = 2.0
"""Mean squared error of a fit that is near enough to the floor for that; above, `CLEAR` counts [1] (chosen)."""


def shift_of_noted(found: CandidateFit, null: NullFit, settings: DiagnosisSettings | None = None) -> float | None:
    """Return when noted torques acted, as a fit shows it; None where that is at their stamps, or not known.

    The hypothesis is fitted with torques that acted elsewhere in their sample, also without one of its effects, which
    may stand for that. The best of these fits counts where n ln(V / V_shifted) exceeds ln n for each parameter that it
    has more, and 6, while V is near the floor, else where ln(V / V_shifted) / 2 > 0.3, and where another half a sample
    leaves more. A delay of measured torques may stand for half a sample: without it no more must be left.

    Args:
        found: The fit.
        null: The nominal model of the same log.
        settings: Settings of the diagnosis.

    Returns:
        Samples from the stamp of a torque to the middle of the time in which it acts.
    """
    settings, data = settings or DiagnosisSettings(), null.data
    names = {candidate.name for candidate in found.hypothesis}
    delays = {candidate.name for candidate in found.hypothesis if candidate.effect.delays_commands}
    commands = not data.record.measured_torque
    if not timing_is_open(data.record) or (commands and delays):
        return None
    others = (0.0, -HELD) if commands else (-HELD, HELD)
    tried = _Shifts(found, null, settings)
    left = {shift: tried.left(shift, delays) for shift in others}
    best = min(left, key=left.__getitem__)
    if left[best] >= tried.left(best + (HELD if best > 0 else -HELD), delays):
        return None
    if delays:
        return best if left[best] < found.chi2 else None
    usual = tried.left(data.record.torque_shift, set())
    if usual > NEAR * data.n_values:
        return best if left[best] < np.exp(-2 * CLEAR) * usual else None
    gain = tried.gain(usual, left[best])
    if gain <= tried.needed:
        gains = (tried.gain(usual, tried.left(best, {name})) + tried.penalty(name) for name in sorted(names))
        gain = max(gains, default=0.0)
    return best if gain > tried.needed else None


class _Shifts:
    """Fits of a hypothesis to a log with torques that acted elsewhere in their sample."""

    def __init__(self, found: CandidateFit, null: NullFit, settings: DiagnosisSettings) -> None:
        self._found, self._null, self._settings = found, null, settings

    @property
    def needed(self) -> float:
        """Twice the gain in log-likelihood that a shift needs."""
        return float(np.log(self._null.data.n_values)) + SURE

    def gain(self, usual: float, chi2: float) -> float:
        """Return twice the gain in log-likelihood of a sum of squares over another one."""
        return self._null.data.n_values * float(np.log(usual / chi2))

    def penalty(self, name: str) -> float:
        """Return the penalty of the parameters of a candidate."""
        return float(self._found.columns([name]).sum() * np.log(self._null.data.n_values))

    def left(self, shift: float, without: Collection[str]) -> float:
        """Return the sum of squares that the hypothesis without some candidates leaves."""
        found, data, settings = self._found, self._null.data, self._settings
        chosen = tuple(candidate for candidate in found.hypothesis if candidate.name not in without)
        predictor = found.predictor if len(chosen) == len(found.hypothesis) else self._null.predictor(chosen)
        start, enough = found.theta[~found.columns(without)], max(settings.fit.enough, data.negligible)
        moved = _moved(data, shift)
        return fit(predictor, moved, start, settings.fit.joint_iterations, enough=enough, settings=settings.fit).chi2


def _moved(data: FitData, shift: float) -> FitData:
    """Return a log whose torques acted elsewhere in their sample."""
    record, torques = shifted(data.record, shift), data.torques
    later = (shift - data.record.torque_shift) * record.sample_time
    return replace(data, record=record, torques=None if torques is None else torques.acting_later(later))
