"""Tolerances of torques on trial."""

from __future__ import annotations

import pytest

from flexros.gap.search.better_torques import LEAST, are_better, most_begun, tolerance_on_trial


def test_less_counts_as_no_gap_than_an_explanation_leaves() -> None:
    tried = tolerance_on_trial(0.05, 0.16)
    assert tried is not None
    assert tried**2 < 0.16 * 0.05**2


@pytest.mark.parametrize(("tolerance", "left"), [(0.05, 1.2), (0.006, 0.1), (0.0, 0.1)])
def test_torques_that_are_hardly_better_are_not_tried(tolerance: float, left: float) -> None:
    assert tolerance_on_trial(tolerance, left) is None


def test_a_tolerance_that_was_on_trial_itself_must_leave_less() -> None:
    """Effects that are missing leave as much as the tolerance that is assumed; once they are found, little is left."""
    assert tolerance_on_trial(0.05, 0.8) is not None
    assert tolerance_on_trial(0.05, 0.8, again=True) is None
    assert tolerance_on_trial(0.05, 0.4, again=True) is not None


def test_no_tolerance_is_below_what_a_simulator_makes_of_its_steps() -> None:
    assert tolerance_on_trial(0.05, 0.0) == LEAST


def test_torques_are_not_better_where_an_explanation_leaves_more_than_was_assumed() -> None:
    """Of the linear drive EMPS curves and a ripple left 204 times the tolerance of 0.5 %, which is 7 %."""
    assert are_better(0.05, 0.007, 5.0)
    assert not are_better(0.05, 0.005, 204.0)


def test_where_no_explanation_was_found_one_within_the_assumed_tolerance_is_enough() -> None:
    """A belt axis with cogging and a wrong rotor was explained by friction alone, and by all with 52 times 0.5 %."""
    assert are_better(0.05, 0.005, 52.4, instead=False)
    assert not are_better(0.05, 0.005, 52.4)
    assert not are_better(0.05, 0.005, 110.0, instead=False)


def test_a_search_without_hope_is_not_begun() -> None:
    """That of EMPS began with 716 times the tolerance of 0.5 %, that of a simulator with 30 times one of 0.7 %."""
    assert most_begun(0.05, 0.007) > 30
    assert most_begun(0.05, 0.005) < 716
