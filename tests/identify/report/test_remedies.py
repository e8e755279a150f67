"""Which experiment would determine what is open: a real gain, confirmed by adding it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.report.remedies import measured_information, remedies
from flexros.identify.report.result import IdentificationResult


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
