"""Proposed experiments: the predicted gain is confirmed by adding the experiment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.report.remedies import measured_information, remedies
from flexros.identify.result import IdentificationResult


def test_nothing_is_proposed_where_all_is_determined(clear: IdentificationResult) -> None:
    assert remedies(clear) == ()


def test_nothing_is_proposed_without_covariance(make: Callable[..., IdentificationResult]) -> None:
    assert remedies(make(1500.0, known=False)) == ()


def test_proposals_cover_what_is_open_and_promise_a_gain(noisy: IdentificationResult) -> None:
    found = remedies(noisy)
    told = " ".join(each.what for each in found)
    for entry in noisy.identifiability.parameters:
        assert (entry.name in told) == (entry.verdict != "determined")
    for each in found:
        assert 0 < each.gain < 1
        assert noisy.problem.frequency[0] <= each.frequency <= noisy.problem.frequency[-1]
        assert any(np.array_equal(each.gears, gears) for gears in noisy.design.candidates.gears)
        same = [k for k, one in enumerate(noisy.problem.responses) if np.allclose(one.gears, each.gears)]
        assert each.position == (same[0] if same else None)


def test_measured_positions_are_proposed_by_number_where_there_is_no_design(noisy: IdentificationResult) -> None:
    """Responses made from plain arrays do not know their gears."""
    bare = tuple(replace(each, gears=np.full(2, np.nan)) for each in noisy.problem.responses)
    plain = replace(noisy, problem=replace(noisy.problem, responses=bare), design=None)
    found, known = remedies(plain), remedies(replace(noisy, design=None))
    assert found
    for each, same in zip(found, known, strict=True):
        assert each.position in range(3)
        assert np.all(np.isnan(each.gears))
        assert (each.position, each.frequency, each.gain) == (same.position, same.frequency, same.gain)
        np.testing.assert_array_equal(same.gears, noisy.problem.responses[same.position].gears)


def test_design_for_other_parameters_gives_no_candidates(noisy: IdentificationResult) -> None:
    assert noisy.design is not None
    other = replace(noisy, design=replace(noisy.design, names=noisy.design.names[::-1]))
    assert [each.position for each in remedies(other)] == [
        each.position for each in remedies(replace(noisy, design=None))
    ]


def test_no_weights_beat_the_measured_information(clear: IdentificationResult) -> None:
    """Diagonal weights, user-defined or optimal, stay above the bound of Cramér and Rao, optimal ones closer to it."""
    bound = np.sqrt(np.diag(np.linalg.inv(measured_information(clear).sum(axis=(0, 1)))))
    deviations = []
    for kind in ("user", "optimal"):
        problem = clear.problem.with_choice("LLS", kind).reweighted(clear.fit.values)
        deviations.append(parameter_covariance(problem, clear.fit, correct=False).standard_deviation)
    user, optimal = deviations
    assert np.all(user > 0.99 * bound)
    assert np.all(optimal > 0.99 * bound)
    assert np.all(optimal < 10 * bound)
    assert np.median(optimal / user) < 1
