"""The page says what was found, and whether the goals were met."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.validation.campaigns.coverage.estimates import DEFAULT
from flexros.validation.campaigns.coverage.figures import ParameterCoverage, Share, WayCoverage
from flexros.validation.campaigns.coverage.page import coverage_page, coverage_summary
from flexros.validation.campaigns.coverage.settings import CoverageSettings


def way(share: float = 0.95, gear: float = 0.01, arm: float = 0.1, undetermined: int = 1) -> WayCoverage:
    parameters = tuple(
        ParameterCoverage(
            name, geared, Share(share, share - 0.03, share + 0.03), error, 0.001, 0.01, 0.011, {"determined": 200}
        )
        for name, geared, error in (
            ("body_1.rz.stiffness", True, gear),
            ("body_3.ry.stiffness", False, arm),
            ("body_3.ry.damping", False, None),
        )
    )
    return WayCoverage(DEFAULT, parameters, Share(share, share - 0.01, share + 0.01), undetermined, 2, 1.1, 1.2, 200)


def test_goals_that_are_met() -> None:
    text = " ".join(coverage_summary([way()], 1500.0))
    assert "cover the truth in 95.0 % (94.0 to 96.0) of 200 repetitions (goal 91 to 98 %: met)" in text
    assert "1 % of a gear spring (goal 5 %: met), 10 % of an arm spring (goal 20 %: met)" in text
    assert "25.0 min (goal 30: met)" in text
    assert "missed" not in text


@pytest.mark.parametrize(
    "changed", [way(share=0.9), way(share=0.985), way(gear=0.06), way(arm=0.3), way(undetermined=3)]
)
def test_goals_that_are_missed(changed: WayCoverage) -> None:
    assert " ".join(coverage_summary([changed], 1500.0)).count("missed") == 1


def test_too_long_an_experiment_is_told() -> None:
    assert "31.0 min (goal 30: missed)" in " ".join(coverage_summary([way()], 1860.0))


def test_page_has_tables_of_ways_and_parameters() -> None:
    other = replace(way(share=0.5), name="LLSM user")
    page = coverage_page([way(), other], CoverageSettings(), 1500.0, {"flexros": "1.2"})
    assert "| LLSM user | 50.0 (49.0 to 51.0) | 50.0 to 50.0 | 0 of 3 |" in page
    assert "| body_1.rz.stiffness | 95.0 | 92.0 to 98.0 | 1 | 0.1 | 1 | 1.1 | determined 200 |" in page
    assert "| body_3.ry.damping | 95.0 | 92.0 to 98.0 | - |" in page
    assert "Versions: flexros 1.2" in page
    assert "15 positions chosen out of 4000" in page


def test_page_says_why_optimal_weights_cover_less() -> None:
    short, fine = (replace(way(share=share), name="NLS optimal") for share in (0.7, 0.95))
    pages = [coverage_page([way(), other], CoverageSettings(), 1500.0, {}) for other in (short, fine)]
    assert ["Intervals of NLS optimal are too short" in page for page in pages] == [True, False]
