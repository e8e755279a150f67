"""Results that are computed once for a fit and a log, and kept while both are in use."""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, TypeVar
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import RankingSettings

Result = TypeVar("Result")
Settings = TypeVar("Settings", bound="RankingSettings | None")


def once_per_fit(
    compute: Callable[[CandidateFit, FitData, Settings], Result],
) -> Callable[[CandidateFit, FitData, Settings], Result]:
    """Return a function of a fit, a log and settings that keeps its results.

    Args:
        compute: The function.
    """
    kept: WeakKeyDictionary[FitData, WeakKeyDictionary[CandidateFit, dict[Settings, Result]]] = WeakKeyDictionary()

    @wraps(compute)
    def known(fit: CandidateFit, data: FitData, settings: Settings) -> Result:
        of_fit = kept.setdefault(data, WeakKeyDictionary()).setdefault(fit, {})
        if settings not in of_fit:
            of_fit[settings] = compute(fit, data, settings)
        return of_fit[settings]

    return known
