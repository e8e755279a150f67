"""Searches that go on where numbers of the model ended at the limit of theirs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from flexros.gap import wider_numbers
from flexros.gap.candidates.tolerance import FARTHER, FARTHEST
from flexros.gap.deadline import Deadline
from flexros.gap.fit.limits import numbers_at_limits
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.forward_selection import Explanations, explain
from flexros.gap.wider_numbers import found_wider
from tests.gap.planar_arm import FRICTION, log_of, searched

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.slow

ROTOR = "motor_inertia_error@motor_2:relative=0.6"
"""No candidate of the search, and nine tolerances off."""


def test_a_number_at_the_limit_of_its_search_goes_farther_where_both_logs_are_for_it(tmp_path: Path) -> None:
    """Of a measured arm of seven axes four frictions had hidden behind masses at five tolerances."""
    search = searched(tmp_path, *FRICTION, ROTOR)
    explanations = explain(search)
    assert "motor_2.inertia" in numbers_at_limits(explanations.chosen)
    further, found = found_wider(search, explanations, log_of(tmp_path, *FRICTION, ROTOR, seed=4))
    tolerance = found.chosen.predictor.tolerance
    factors = dict(zip(tolerance.names, tolerance.logarithms(found.chosen.deviations), strict=True))
    assert factors["motor_2.inertia"] == pytest.approx(0.47, abs=0.05)
    assert not numbers_at_limits(found.chosen)
    assert found.chosen.names >= {one.partition(":")[0] for one in FRICTION}
    assert further.null.predictor(()).bounds[1].max() == FARTHER


@pytest.mark.parametrize("refuted", [True, False])
def test_it_stays_where_another_log_refutes_it_and_where_no_number_ended_there(refuted: bool, tmp_path: Path) -> None:
    truth = (*FRICTION, ROTOR) if refuted else FRICTION
    search = searched(tmp_path, *truth)
    explanations = explain(search)
    kept = found_wider(search, explanations, log_of(tmp_path, *FRICTION, seed=4))
    assert kept == (search, explanations)
    assert search.null.predictor(()).bounds[1].max() == FARTHEST


def test_the_damping_of_a_spring_alone_is_no_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It hardly shows: a second search of three elastic axes found what the first one had found."""
    search = searched(tmp_path, *FRICTION, ROTOR)
    explanations = explain(search)
    monkeypatch.setattr(wider_numbers, "numbers_at_limits", lambda _: {"body_1.rz.damping", "body_2.ry.damping"})
    assert found_wider(search, explanations, log_of(tmp_path, *FRICTION, ROTOR, seed=4)) == (search, explanations)


def test_what_was_cut_short_takes_the_place_of_no_complete_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its probabilities would compare what was tried until then: of six elastic axes friction was ambiguous."""
    search = searched(tmp_path, *FRICTION, ROTOR)
    explanations, ended = explain(search), list[bool]()
    search = replace(search, deadline=Deadline(interrupted=lambda: bool(ended)))

    def cut_short(further: Search) -> Explanations:
        found = explain(further)
        ended.append(True)
        return found

    monkeypatch.setattr(wider_numbers, "explain", cut_short)
    assert found_wider(search, explanations, log_of(tmp_path, *FRICTION, ROTOR, seed=4)) == (search, explanations)
    assert ended
