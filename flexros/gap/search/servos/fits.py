"""Fits of servos to one log: little from every start, longer where it is worth it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.gap.fit.least_squares import fit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.search.servos.plan import Begun
    from flexros.gap.settings import DiagnosisSettings


@dataclass(frozen=True)
class ServoFits:
    """Fits of servos to one log.

    Attributes:
        null: The nominal model, fitted.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; None to go on to the end.
        progress: Called with "servos" and the share of all work; None for nobody.
    """

    null: NullFit
    settings: DiagnosisSettings
    stop: Callable[[], bool] | None
    progress: Callable[[str, float], None] | None

    @property
    def over(self) -> bool:
        """Whether the time is over."""
        return self.stop is not None and self.stop()

    def screened(self, begun: Begun, own: Mapping[str, float]) -> CandidateFit:
        """Fit effects a little, from values by their names where these are given; tolerated deviations stay at zero."""
        null, begin = self.null, self.settings.servo_start
        predictor = null.predictor(tuple(one for one, _ in begun))
        sizes = [
            free.encode(own.get(one.name, value) if free is one.free[0] else free.starts[0])
            for one, value in begun
            for free in one.free
        ]
        n_tolerated = predictor.tolerance.n_free
        theta = np.clip(np.concatenate([sizes, np.zeros(n_tolerated)]), *predictor.bounds)
        return fit(
            predictor,
            null.data,
            theta,
            begin.first_iterations,
            tolerance_slopes=np.broadcast_to(0.0, (len(null.data.used), n_tolerated)),
            settings=self.settings.fit,
            stop=self.stop,
        )

    def longer(self, one: CandidateFit, iterations: int | None = None) -> CandidateFit:
        """Let a fit go on, for the iterations of the settings unless others are given."""
        most = self.settings.servo_start.iterations if iterations is None else iterations
        return fit(one.predictor, self.null.data, one.theta, most, settings=self.settings.fit, stop=self.stop)

    def every(
        self, starts: Sequence[tuple[Any, ...]], fitted: Callable[..., CandidateFit], begins: float, ends: float
    ) -> list[CandidateFit]:
        """Fit from several starts, and tell the share of all work before each, between two shares.

        With many servos a single iteration takes long, so that once the time is over, no fit is begun but the first.
        """
        fits: list[CandidateFit] = []
        for done, start in enumerate(starts):
            if fits and self.over:
                break
            if self.progress is not None:
                self.progress("servos", begins + (ends - begins) * done / len(starts))
            fits.append(fitted(*start))
        return fits

    def likeliest(self, fits: Sequence[CandidateFit]) -> CandidateFit | None:
        """Return the fit with the best Bayesian information criterion X / m + p log n (Schwarz 1978), if any.

        The sum of squares X counts over the mean square m that the best fit leaves, if that is more than noise leaves.
        """
        n = self.null.data.n_values
        finite = [one for one in fits if np.isfinite(one.chi2)]
        left = max(min((one.chi2 for one in finite), default=0.0) / n, 1.0)
        return min(finite, key=lambda one: one.chi2 / left + len(one.theta) * np.log(n), default=None)


def promising(fits: Sequence[CandidateFit], most: int) -> list[CandidateFit]:
    """Return the best fits of each list of effects, the best of all first.

    Args:
        fits: The fits.
        most: Most fits of the same effects.
    """
    ranked = sorted((one for one in fits if np.isfinite(one.chi2)), key=lambda one: one.chi2)
    kept: list[CandidateFit] = []
    for one in ranked:
        if sum(other.names == one.names for other in kept) < most:
            kept.append(one)
    return kept
