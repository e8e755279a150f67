"""The result as figures: agreement with truth, verdict, JSON, warnings."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.report.record import identification_record
from flexros.identify.report.verdict import kept_text, verdict
from flexros.identify.result import ExperimentFacts, IdentificationResult

pytestmark = pytest.mark.slow


def test_figures_hold_truth_within_their_intervals(clear: IdentificationResult) -> None:
    content = identification_record(clear)
    inside = [row["interval_95"][0] <= row["truth"] <= row["interval_95"][1] for row in content["parameters"]]
    assert len(inside) == 6
    assert sum(inside) >= 5
    for row in content["parameters"]:
        assert row["value"] == pytest.approx(row["truth"], rel=5 * row["relative_std"])
        assert row["verdict"] == "determined"


def test_dictionary_is_json_with_all_that_matters(clear: IdentificationResult) -> None:
    content = json.loads(json.dumps(identification_record(clear)))
    assert content["schema"] == 1
    assert content["robot"] == "e12"
    assert content["cost"]["identified"] < 0.1 * content["cost"]["nominal"]
    assert content["starts"] == {
        "number": 4, "failed": 0, "same_minimum": clear.same_minimum,
        "costs": sorted(each.cost for each in clear.searched),
    }  # fmt: skip
    assert content["experiment"]["robot_time"] == 400.0
    assert np.array(content["positions"]).shape == (3, 2)


def test_starts_that_failed_do_not_count(clear: IdentificationResult) -> None:
    failed = replace(clear.searched[0], cost=np.nan, converged=False)
    result = replace(clear, searched=(failed, *clear.searched, failed))
    assert result.same_minimum == clear.same_minimum
    starts = identification_record(result)["starts"]
    assert (starts["number"], starts["failed"], len(starts["costs"])) == (6, 2, 4)


def test_verdict_counts_and_names(clear: IdentificationResult, noisy: IdentificationResult) -> None:
    assert verdict(clear).startswith("6 of 6 parameters of e12 are determined within 10 %. The identified model ")
    open_ones = noisy.identifiability.names("not_determined")
    assert open_ones
    assert f"not determined ({open_ones[0]}" in verdict(noisy)


def test_what_keeps_its_nominal_value_is_named(clear: IdentificationResult, noisy: IdentificationResult) -> None:
    assert (clear.kept_nominal, kept_text(clear)) == ((), "")
    told = ", ".join(noisy.identifiability.names("not_determined"))
    assert kept_text(noisy).startswith(f"The identified robot keeps the nominal values of {told}: not determined, or ")


def test_verdict_says_when_the_nominal_values_do_as_well(clear: IdentificationResult) -> None:
    assert re.search(r"it leaves 0?\.?\d+ % of what the nominal values leave unexplained", verdict(clear))
    same = replace(clear, fit=replace(clear.fit, cost=0.95 * clear.nominal_cost))
    assert verdict(same).endswith("the nominal values explain them nearly as well.")


def test_verdict_tells_large_misfits_without_exponent(clear: IdentificationResult) -> None:
    missing = replace(clear, covariance=replace(clear.covariance, reduced_cost=350.4**2))
    assert "by 350 times their uncertainty (rms)" in verdict(missing)


def test_verdict_says_when_errors_are_not_known(make: Callable[..., IdentificationResult]) -> None:
    assert "The errors of the responses in 3 positions are not known" in verdict(make(10.0, known=False))


def test_warnings_that_differ_in_numbers_only_are_told_once(clear: IdentificationResult) -> None:
    assert clear.warnings[:2] == (
        "amplitudes were lowered",
        "position 1: a gap of 2 samples (alike in 2 more positions)",
    )


def test_facts_are_those_of_the_plan() -> None:
    from flexros.scenario.identification_plan import plan_of_scenario
    from flexros.scenario.scenario import load_scenario

    facts = ExperimentFacts.of(plan_of_scenario(load_scenario("identify_six_axis")), "log", "direct")
    assert (facts.positions, facts.blocks, facts.experiments, facts.periods, facts.period) == (3, 6, 36, 2, 2.0)
    assert facts.robot_time == pytest.approx(314, abs=5)
    assert facts.excitation == "multisine"
