"""Overtones of a torque ripple: found where its wave is no pure sine, and small effects show beside them."""

from __future__ import annotations

import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import parameters_of
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.periodic.overtones import with_overtones
from flexros.record.premises import MEASURED
from tests.gap.diagnosis_logs import WHOLE, search_of

pytestmark = pytest.mark.slow

RIPPLE = "torque_ripple@motor_1:amplitude=0.1,order=6,phase=0.4"


def found(search: Search) -> CandidateFit:
    """Fit the ripple as a pure sine."""
    ripples = [one for one in search.harmonics(search.null.fit) if one.name == RIPPLE.partition(":")[0]]
    return search.singles(search.directions(ripples))[0]


def test_a_wave_that_is_no_pure_sine_has_its_overtone() -> None:
    search = search_of(f"{RIPPLE},second_sine=0.1,second_cosine=-0.05", length=WHOLE)
    pure = found(search)
    wavy = with_overtones(search, pure, fits := [])
    assert fits == [wavy]
    assert wavy.names == pure.names
    assert search.data.n_values * 0.95 < wavy.chi2 < search.data.n_values * 1.05 < pure.chi2
    (sizes,) = parameters_of(wavy, search.data)
    for name, value in (("second_sine", 0.1), ("second_cosine", -0.05), ("amplitude", 0.1)):
        assert abs(sizes[name].value - value) < 4 * sizes[name].std
    assert with_overtones(search, wavy, fits) is wavy


@pytest.mark.parametrize(("second", "found_there"), [(0.1, True), (0.005, False)])
def test_in_a_measured_log_it_must_lower_all_that_is_left(
    second: float, found_there: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(f"{RIPPLE},second_sine={second}", length=WHOLE)
    pure = found(search)
    assert with_overtones(search, pure, []) is not pure
    monkeypatch.setattr(Search, "premises", MEASURED)
    assert (with_overtones(search, pure, []) is not pure) is found_there


def test_a_pure_sine_stays_one() -> None:
    search = search_of(RIPPLE, length=WHOLE)
    pure = found(search)
    assert with_overtones(search, pure, fits := []) is pure
    assert not fits
