"""What the search knows of a log beside its fits."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.search.prepare import prepare_search
from tests.gap.diagnosis_logs import MODEL, data_of, settings_of


def left(errors: Any, prior: float = 0.0) -> Any:
    """A fit that leaves given errors."""
    return SimpleNamespace(residual=lambda _: errors.copy(), prior_penalty=prior)


@pytest.mark.parametrize("everywhere", [True, False])
def test_a_difference_of_some_parts_of_a_log_is_chance_and_one_of_all_parts_is_none(everywhere: bool) -> None:
    null = fit_null(data_of(), MODEL, Tolerance())
    search = prepare_search(null, settings_of("coulomb_friction"))
    same = np.ones_like(null.fit.residual(null.data))
    more = same.copy()
    more[slice(None) if everywhere else slice(round(1 / null.data.record.sample_time))] = 2.0
    difference = float(np.sum(more**2) - np.sum(same**2))
    assert (search.chance(left(more), left(same)) < 0.2 * difference) is everywhere


def test_tolerated_numbers_that_were_weighed_by_a_large_misfit_are_no_evidence() -> None:
    null = fit_null(replace(data_of(), misfit=6.0), MODEL, Tolerance())
    search = prepare_search(null, settings_of("coulomb_friction"))
    same = np.ones_like(null.fit.residual(null.data))
    assert search.chance(left(same, 7.0), left(same, 3.0)) == pytest.approx(5.0 * 4.0)
