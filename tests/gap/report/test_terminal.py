"""Printed answer of a diagnosis."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace

from rich.console import Console

from flexros.gap.report.terminal import (
    budget_lines,
    gap_line,
    group_lines,
    next_lines,
    number_lines,
    other_figures_line,
    ranking_table,
    rest_lines,
    tolerance_lines,
    verdict_line,
    where_lines,
)
from flexros.gap.report.words import undetermined_words
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import CauseParameter, Diagnosis, EffectLocation, ModelNumber

Diagnosed = Callable[[str], DiagnosisResult]


def test_verdict_comes_with_its_word(diagnosed: Diagnosed) -> None:
    assert verdict_line(diagnosed("explained").diagnosis).startswith("explained: The gap comes from Coulomb friction")


def test_ranking_ends_with_nothing(diagnosed: Diagnosed) -> None:
    text = io.StringIO()
    Console(file=text, width=140).print(ranking_table(diagnosed("explained")))
    lines = text.getvalue().splitlines()
    assert lines[1].split()[:6] == ["Coulomb", "friction", "at", "motor_1", "97", "%"]
    assert lines[-1].split() == ["Nothing", "0", "%", "0", "100", "%"]


def test_figures_of_effects_together_are_printed_at_the_first(diagnosed: Diagnosed) -> None:
    first, second, *_ = diagnosed("explained").ranking
    partners = [(EffectLocation(effect=one.effect, location=one.location),) for one in (second, first)]
    pair = tuple(replace(one, together_with=others) for one, others in zip((first, second), partners, strict=True))
    text = io.StringIO()
    Console(file=text, width=140).print(ranking_table(replace(diagnosed("explained"), ranking=pair)))
    lines = text.getvalue().splitlines()
    assert "5378" in lines[1]
    assert lines[2].split()[:5] == ["Hysteresis", "at", "motor_1", "3", "%"]
    assert lines[2].split()[5] == "level"


def test_gap_is_one_line(diagnosed: Diagnosed) -> None:
    assert gap_line(diagnosed("explained").diagnosis.gap).endswith(
        ": 38.20 before, 1.120 after, floor 1, best rival 2.900, 99.7 % closed (98.7 % to 99.9 %)"
    )
    assert gap_line(diagnosed("no_gap").diagnosis.gap).endswith(": 1.030 before, floor 1")


def test_a_gap_that_was_tied_more_loosely_is_stated_as_that_of_the_model_alone_too(diagnosed: Diagnosed) -> None:
    gap = diagnosed("explained").diagnosis.gap.model_copy(update={"before": 3.49e6, "before_alone": 6.07e5})
    assert "3490000 before (607000 as flexros gap states it)" in gap_line(gap)


def test_other_figures_of_a_log_that_a_diagnosis_held_out_are_explained(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis.model_copy(update={"provenance": {"log": "slow", "holdout": "fast"}})
    gap = diagnosis.gap.model_copy(update={"after": 0.9})
    line = other_figures_line(diagnosis, "fast", gap)
    assert "The diagnosis of slow states 38.20 before and 1.120 after for this log" in line
    assert "are those of the fitted log, here those of this log" in line
    assert other_figures_line(diagnosis, "other", gap) == ""
    assert other_figures_line(diagnosis, "fast", diagnosis.gap) == ""
    alone = diagnosis.model_copy(update={"provenance": {"log": "fast", "holdout": "fast"}})
    assert "for its last part" in other_figures_line(alone, "fast", gap)


def test_the_first_three_locations_are_listed(diagnosed: Diagnosed) -> None:
    lines = where_lines(diagnosed("explained"))
    assert lines[0] == "motor_1, below 2 Hz: 61 % of the excess, p < 0.001"
    assert len(lines) == 3


def test_groups_and_next_experiment_are_listed(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("ambiguous").diagnosis
    assert group_lines(diagnosis) == ("Not distinguishable: hysteresis at motor_1 and backlash at motor_1",)
    assert next_lines(diagnosis)[1] == "  flexros run bias_steps --model four_mass_linear --out bags/bias_steps"
    assert next_lines(diagnosed("explained").diagnosis) == ()


def test_the_budget_has_a_waterfall_and_both_shares(divided: Diagnosis) -> None:
    lines = budget_lines(divided)
    assert lines[0] == "motor_1"
    assert lines[-3:] == (
        "Hysteresis at motor_1 (friction): 60 % removed last, worse alone",
        "Coulomb friction at motor_1: 20 % removed last, 25 % added first",
        "Worse alone: the effect has the size at which it explains the log together with the others",
    )


def test_effects_without_which_the_others_are_worse_than_none_say_so(divided: Diagnosis) -> None:
    """An arm of seven axes: "398 % (284 % to 607 %) removed last, worse alone"."""
    needed, other = divided.budget
    shares = (needed.model_copy(update={"share_last": 3.98, "interval_last": (2.84, 6.07)}), other)
    lines = budget_lines(divided.model_copy(update={"budget": shares}))
    assert lines[-4] == "Hysteresis at motor_1 (friction): worse without it, worse alone"
    assert lines[-2] == "Worse without it: the other effects without this one predict worse than the nominal model"


def test_the_budget_has_its_intervals_and_classes(divided: Diagnosis) -> None:
    first, second = divided.budget
    shares = (
        first.model_copy(update={"cause_class": "gear", "share_last": -0.08, "interval_last": (-0.12, -0.04)}),
        second.model_copy(update={"share_last": 0.91, "interval_last": (0.85, 0.96)}),
    )
    lines = budget_lines(divided.model_copy(update={"budget": shares}))
    assert "Hysteresis at motor_1 (gear): \u22128 % (worse, \u221212 % to \u22124 %) removed last" in lines[-3]
    assert "Coulomb friction at motor_1: 91 % (85 % to 96 %) removed last" in lines[-2]


def test_numbers_that_the_model_lacks_are_all_listed_and_come_before_wrong_ones(diagnosed: Diagnosed) -> None:
    def found(name: str, nominal: float) -> ModelNumber:
        return ModelNumber(location="tool", name=name, nominal=nominal, value=0.96, std=0.04, unit="kg")

    wrong = tuple(found(f"body_{index}.mass", 1.2) for index in range(1, 7))
    numbers = (*wrong, *(found(name, 0.0) for name in ("tool_load.mass", "tool_load.x")))
    lines = number_lines(diagnosed("explained").diagnosis.model_copy(update={"model_numbers": numbers}))
    assert lines[0] == "tool_load: mass 0.960 kg (±0.040), x 0.960 kg (±0.040)"
    assert lines[1] == "body_1: mass 0.960 kg (±0.040) instead of 1.200"
    assert lines[-1] == "and those of 2 more, in report and patch"


def test_a_number_at_the_limit_of_its_search_is_no_finding(diagnosed: Diagnosed) -> None:
    rotor = ModelNumber(
        location="motor_1", name="motor_1.inertia", nominal=118, value=151.5, std=0.01, unit="kg", at_limit=True
    )
    (line,) = number_lines(diagnosed("explained").diagnosis.model_copy(update={"model_numbers": (rotor,)}))
    assert line == "motor_1: inertia 151.5 kg or beyond (limit of its search) instead of 118"


def test_the_rest_has_joint_motion_and_band(divided: Diagnosis) -> None:
    assert rest_lines(divided) == ("motor_1: 15 %: at reversals 12 %, below 2 Hz 10 %",)


def test_a_single_effect_that_leaves_nothing_has_no_budget(diagnosed: Diagnosed) -> None:
    assert budget_lines(diagnosed("explained").diagnosis) == ()
    assert rest_lines(diagnosed("explained").diagnosis) == ()


def test_names_that_change_with_the_tolerances_are_listed(guessed: Diagnosis) -> None:
    lines = tolerance_lines(guessed)
    assert len(lines) == 2
    assert lines[0].startswith("Hysteresis at motor_1: 99 % with halved")
    assert lines[1].endswith("98 % with doubled ones")


def test_it_is_said_when_no_name_changes(guessed: Diagnosis) -> None:
    (sure,) = (row for row in guessed.tolerance_sensitivity if not row.changes)
    (line,) = tolerance_lines(guessed.model_copy(update={"tolerance_sensitivity": (sure,)}))
    assert line.startswith("No name changes")
    assert tolerance_lines(guessed.model_copy(update={"tolerance_sensitivity": ()})) == ()


def test_a_cause_without_a_size_is_said_to_be_present_only(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    level = CauseParameter(value=0.1, std=0.2, unit="Nm", determined=False)
    cause = diagnosis.causes[0].model_copy(update={"parameters": {"level": level}, "determined": False})
    assert undetermined_words(diagnosis.causes) == ()
    assert undetermined_words((cause,)) == (
        "Coulomb friction at motor_1: present, size not determined: between -0.30 and 0.50 Nm",
    )
