"""The verdict in words: a large misfit comes first, and inertias are named where it sits in their lines."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.identify.report.undetermined import UndeterminedSection
from flexros.identify.report.verdict import advice, verdict
from flexros.identify.result import IdentificationResult


def missed(result: IdentificationResult, reduced: float) -> IdentificationResult:
    """Return the result with another cost over its expected value."""
    return replace(result, covariance=replace(result.covariance, reduced_cost=reduced))


def with_misfit(result: IdentificationResult, diagonal: float, low: float) -> IdentificationResult:
    """Put a share of the cost at low frequencies, and a part of each band on the diagonal of motor_1."""
    cells = []
    for lowest, share in ((1.0, low), (5.0, 0.0), (30.0, 0.0), (60.0, 1 - low)):
        for pair, part in (("11", diagonal), ("12", (1 - diagonal) / 2), ("21", (1 - diagonal) / 2), ("22", 0.0)):
            names = {"output": f"motor_{pair[0]}", "input": f"motor_{pair[1]}", "share": share * part}
            cells.append(replace(result.residuals.cells[0], lowest=lowest, **names))
    return replace(missed(result, 400.0), residuals=replace(result.residuals, cells=tuple(cells)))


def test_large_misfit_comes_first(clear: IdentificationResult) -> None:
    text = verdict(missed(clear, 400.0))
    assert text.startswith("The identified model misses the responses in 3 positions by 20 times their uncertainty")
    assert text.endswith(
        "6 of 6 parameters of e12 are determined within 10 % as far as noise goes, which is not what limits them here."
    )
    assert verdict(missed(clear, 4.0)).startswith("6 of 6 parameters of e12 are determined within 10 % as far as noise")


def test_misfit_of_a_minimum_found_once_may_be_that_of_the_search(clear: IdentificationResult) -> None:
    best, other = clear.fit, replace(clear.fit, cost=2 * clear.fit.cost)
    once, twice = (replace(missed(clear, 400.0), searched=each) for each in ((best, other, other), (best, best)))
    assert "Of 3 starts 1 ended here" in verdict(once)
    assert "more initial values" in verdict(once)
    assert "the model has a form error: the robot" in verdict(twice).lower()


def test_misfit_of_lines_counts_too(clear: IdentificationResult) -> None:
    lines = replace(clear, residuals=replace(clear.residuals, chi_square=900.0))
    assert verdict(lines).startswith("The identified model misses the responses in 3 positions by 30 times")


def test_single_position_and_parameter_are_told_as_such(clear: IdentificationResult) -> None:
    one = replace(clear, problem=replace(clear.problem, responses=clear.problem.responses[:1]))
    vars(one).update(limits=clear.limits, nominal_cost=clear.nominal_cost)
    assert "explains the response within its uncertainty" in verdict(one)
    judged = replace(clear.identifiability, parameters=clear.identifiability.parameters[:1])
    alone = replace(clear, fit=replace(clear.fit, names=clear.fit.names[:1]), identifiability=judged)
    vars(alone).update(limits=clear.limits, nominal_cost=clear.nominal_cost)
    assert "1 of 1 parameter of e12 is determined within 10 %" in verdict(alone)


def test_inertia_is_named_where_the_misfit_is_in_its_line(clear: IdentificationResult) -> None:
    told = advice(with_misfit(clear, diagonal=0.9, low=0.4))
    assert told.startswith("90 % of the misfit from ")
    assert told.endswith("adding motor_1.inertia to the unknown parameters.")


@pytest.mark.parametrize(("diagonal", "low"), [(0.5, 0.4), (0.9, 0.95)])
def test_inertia_is_not_named_elsewhere(clear: IdentificationResult, diagonal: float, low: float) -> None:
    assert advice(with_misfit(clear, diagonal, low)) == ""
    assert advice(clear) == ""


def test_large_misfit_silences_advice_on_noise(noisy: IdentificationResult) -> None:
    texts = [str(block) for block in UndeterminedSection().blocks(noisy)]
    less = [str(block) for block in UndeterminedSection().blocks(missed(noisy, 400.0))]
    assert any("hardly depend on it anywhere" in text for text in texts)
    assert not any("hardly depend on it anywhere" in text or "Optimal weights" in text for text in less)
