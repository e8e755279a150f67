"""Sizes are known no better than the fitted and the held-out log agree on them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import parameters_of
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.uncertainty import between_logs
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.schema import CauseParameter
from flexros.gap.settings import FitSettings, RankingSettings
from tests.gap.diagnosis_logs import candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow

LEVEL = 0.03


def log_of(level: float, *, imported: bool = True) -> FitData:
    data = data_of(f"coulomb_friction@motor_1:level={level}")
    return replace(data, record=replace(data.record, imported=imported))


@pytest.fixture(scope="module")
def found() -> CandidateFit:
    candidate = candidates_of(f"coulomb_friction@motor_1:level={LEVEL}")["coulomb_friction@motor_1"]
    start = np.array(encoded(candidate, level=LEVEL))
    return fit(predictor_of(candidate), log_of(LEVEL), start, 20, enough=FitSettings().exactly)


def size_of(found: CandidateFit, held: FitData | None) -> CauseParameter:
    return parameters_of(found, log_of(LEVEL), RankingSettings(), held)[0]["level"]


def test_a_size_that_the_held_out_log_has_as_well_keeps_its_deviation(found: CandidateFit) -> None:
    assert size_of(found, log_of(LEVEL)).std == pytest.approx(size_of(found, None).std)


def test_a_size_is_known_no_better_than_two_logs_differ(found: CandidateFit) -> None:
    """The deviation of two estimates from their mean, not from each other, which is as much as two logs can tell."""
    alone, both = size_of(found, None), size_of(found, log_of(1.5 * LEVEL))
    assert both.value == alone.value
    assert alone.std < 0.05 * LEVEL
    assert both.std == pytest.approx(0.5 * LEVEL / np.sqrt(2), rel=0.3)


def test_simulated_logs_lack_nothing_that_sizes_could_take_up(found: CandidateFit) -> None:
    held = log_of(1.5 * LEVEL, imported=False)
    assert size_of(found, held).std == pytest.approx(size_of(found, None).std)


def test_a_log_whose_predictions_run_away_says_nothing_of_sizes(
    found: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(between_logs, "linearised", lambda *_: SimpleNamespace(chi2=np.inf))
    assert size_of(found, log_of(1.5 * LEVEL)).std == pytest.approx(size_of(found, None).std)
