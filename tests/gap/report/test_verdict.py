"""The sentence at the top of a report."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flexros.gap.report.terminal import gap_line, group_lines, tolerance_lines
from flexros.gap.report.verdict import partial_sentence, reported_causes, tolerance_sentence, verdict_sentence
from flexros.gap.report.words import cause_words
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import (
    ANSWERED,
    BUDGET,
    NEXT_EXPERIMENT,
    BudgetShare,
    Diagnosis,
    EffectLocation,
    ModelNumber,
    Partial,
)

Diagnosed = Callable[[str], DiagnosisResult]


def test_a_gap_that_is_explained_names_cause_size_and_what_it_closes(diagnosed: Diagnosed) -> None:
    assert verdict_sentence(diagnosed("explained").diagnosis) == (
        "The gap comes from Coulomb friction at motor_1, 0.213 Nm (±0.011), with a probability of 97 %. On held-out "
        "data the repaired model closes 99.7 % of the gap (98.7 % to 99.9 %): 38.2 before, 1.12 after, "
        "1 without any gap."
    )


def test_sizes_of_what_the_model_lacks_are_stated(diagnosed: Diagnosed) -> None:
    values = {"class": "model numbers", "share_first": None, "share_last": 0.1, "interval": None}
    rows = (
        {**values, "joint": "motor_1", "location": "motor_1", "effect": "rotor_inertia"},
        {**values, "joint": "tool", "location": "tool", "effect": "tool_load"},
    )
    numbers = (
        ModelNumber(location="motor_1", name="motor_1.inertia", nominal=0, value=0.81, std=0.024, unit="kg m2"),
        ModelNumber(location="tool", name="tool_load.mass", nominal=0, value=0.74, std=0.2, unit="kg"),
    )
    given = {"budget": tuple(BudgetShare.model_validate(row) for row in rows), "model_numbers": numbers}
    text = verdict_sentence(diagnosed("explained").diagnosis.model_copy(update=given))
    assert (
        "The model lacked rotor inertia at motor_1, 0.810 kg m2 (±0.024) and tool load at the tool, 0.74 kg (±0.20)."
    ) in text
    unclear = numbers[0].model_copy(update={"determined": False})
    text = verdict_sentence(
        diagnosed("explained").diagnosis.model_copy(update={**given, "model_numbers": (unclear, numbers[1])})
    )
    assert "The model lacked tool load at the tool" in text


def test_many_rotors_are_gathered_behind_a_load(diagnosed: Diagnosed) -> None:
    values = {"class": "model numbers", "share_first": None, "share_last": 0.1, "interval": None}
    places = [("motor_1", "rotor_inertia"), ("motor_2", "rotor_inertia"), ("motor_3", "rotor_inertia")]
    rows = [{**values, "joint": at, "location": at, "effect": name} for at, name in (*places, ("tool", "tool_load"))]
    sizes = [(at, f"{at}.inertia", 0.2 * int(at[-1]), "kg m2") for at, _ in places]
    numbers = tuple(
        ModelNumber(location=at, name=name, nominal=0, value=value, std=0.01, unit=unit)
        for at, name, value, unit in (*sizes, ("tool", "tool_load.mass", 0.96, "kg"))
    )
    given = {"budget": tuple(BudgetShare.model_validate(row) for row in rows), "model_numbers": numbers}
    assert (
        "The model lacked tool load at the tool, 0.960 kg (±0.010) and rotor inertia (motor_1, motor_2 and motor_3), "
        "0.20 to 0.60 kg m2."
    ) in verdict_sentence(diagnosed("explained").diagnosis.model_copy(update=given))


def test_no_gap_of_a_model_that_lacks_a_number_is_that_of_the_patch(diagnosed: Diagnosed) -> None:
    rotor = ModelNumber(location="motor_1", name="motor_1.inertia", nominal=0, value=0.81, std=0.024, unit="kg m2")
    text = verdict_sentence(diagnosed("no_gap").diagnosis.model_copy(update={"model_numbers": (rotor,)}))
    assert text.endswith(
        "The model lacked rotor inertia at motor_1, 0.810 kg m2 (±0.024): it is the model with the patch that agrees."
    )


def test_a_load_that_is_named_as_a_cause_is_not_told_twice(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    cause = diagnosis.causes[0]
    load = cause.model_copy(update={"effect": "tool_load", "location": "tool"})
    row = {"class": "model numbers", "share_first": None, "share_last": 0.1, "interval": None, "joint": "tool"}
    share = BudgetShare.model_validate({**row, "location": "tool", "effect": "tool_load"})
    text = verdict_sentence(diagnosis.model_copy(update={"causes": (load,), "budget": (share,)}))
    assert "The gap comes from tool load at the tool" in text
    assert "The model lacked" not in text


def test_no_gap_names_the_floor(diagnosed: Diagnosed) -> None:
    text = verdict_sentence(diagnosed("no_gap").diagnosis)
    assert text.startswith("No gap: model and log agree")
    assert "1.03 against a floor of 1" in text


def test_rivals_are_both_named_with_the_experiment_that_separates_them(diagnosed: Diagnosed) -> None:
    text = verdict_sentence(diagnosed("ambiguous").diagnosis)
    assert "cannot distinguish hysteresis at motor_1 (56 %) from backlash at motor_1 (43 %)" in text
    assert text.endswith("run bias_steps next.")


def test_an_unknown_effect_is_reported_with_remainder_and_location(diagnosed: Diagnosed) -> None:
    text = verdict_sentence(diagnosed("unknown_effect").diagnosis)
    assert "no known effect explains" in text
    assert "leaves 42 % of it on held-out data" in text
    assert "It is largest in motor_1, below 2 Hz: 61 % of the excess (p < 0.001)." in text


@pytest.mark.parametrize(("n", "words"), [(1, ""), (2, " and 1 other effect"), (3, " and 2 other effects")])
def test_what_several_effects_leave_is_not_said_of_one(diagnosed: Diagnosed, n: int, words: str) -> None:
    diagnosis = diagnosed("unknown_effect").diagnosis
    values = {"class": "timing", "effect": "delay", "share_first": 0.1, "share_last": 0.1, "interval": None}
    shares = tuple(BudgetShare.model_validate({**values, "joint": name, "location": name}) for name in "abc"[:n])
    text = " ".join(verdict_sentence(diagnosis.model_copy(update={"budget": shares})).split())
    assert ("the best explanation, " if words else "the best one, ") in text
    assert f"{cause_words(diagnosis.causes[0])}{words}, leaves 42 % of it" in text


def test_both_causes_of_a_pair_are_reported(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    first, second, *rest = diagnosis.causes
    pair = diagnosis.model_copy(update={"causes": (first, second.model_copy(update={"probability": 0.9}), *rest)})
    assert [cause.effect for cause in reported_causes(pair)] == ["coulomb_friction", "hysteresis"]
    text = verdict_sentence(pair)
    assert "Coulomb friction at motor_1, 0.213 Nm (±0.011) and hysteresis at motor_1" in text
    assert "each with a probability of at least 90 %" in text


def test_nearly_certain_causes_are_not_said_to_be_more_than_that(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    causes = tuple(cause.model_copy(update={"probability": 0.992}) for cause in diagnosis.causes[:2])
    text = verdict_sentence(diagnosis.model_copy(update={"causes": causes}))
    assert "each with a probability of over 99 %. " in text


def test_a_repair_that_makes_it_worse_is_reported(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    gap = diagnosis.gap.model_copy(update={"after": 50.0, "closed_fraction": -0.3})
    text = verdict_sentence(diagnosis.model_copy(update={"gap": gap}))
    assert text.endswith("the repaired model does not close the gap: 38.2 before, 50 after, 1 without any gap.")


def test_of_many_rivals_the_most_probable_are_reported(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("ambiguous").diagnosis
    others = tuple(EffectLocation(effect=name, location="motor_1") for name in ("torque_bias", "actuator_lag", "delay"))
    many = diagnosis.model_copy(update={"ambiguity_groups": ((*others, *diagnosis.ambiguity_groups[0]),)})
    text = verdict_sentence(many)
    assert "hysteresis at motor_1 (56 %), backlash at motor_1 (43 %), torque bias at motor_1 (0 %) from 2" in text


def test_a_rival_with_other_tolerances_alone_is_said_to_be_one(guessed: Diagnosis) -> None:
    """Its probability with the stated ones, 0 %, does not say why it is a rival."""
    never = tuple(
        one.model_copy(update={"probability": 0.0}) if one.effect == "backlash" else one for one in guessed.causes
    )
    text = verdict_sentence(guessed.model_copy(update={"causes": never}))
    assert "from backlash at motor_1 (with doubled tolerances)" in text


def test_an_effect_whose_presence_is_not_decided_is_reported_alone(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("ambiguous").diagnosis
    alone = diagnosis.model_copy(update={"ambiguity_groups": (diagnosis.ambiguity_groups[0][:1],)})
    assert "does not show whether there is hysteresis at motor_1 (56 %)" in verdict_sentence(alone)
    assert group_lines(alone) == ("Not decided: whether there is hysteresis at motor_1",)


def test_no_share_is_stated_of_a_gap_below_the_floor(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    gap = diagnosis.gap.model_copy(update={"before": 0.8, "after": 0.7, "closed_fraction": 1.0})
    text = verdict_sentence(diagnosis.model_copy(update={"gap": gap}))
    assert text.endswith(
        "too small to show in predictions of held-out data: 0.800 before, 0.700 after, 1 without any gap."
    )
    assert gap_line(gap).endswith("0.8000 before, 0.7000 after, floor 1, best rival 2.900")


def test_no_share_is_stated_of_a_gap_within_its_sampling_error(diagnosed: Diagnosed) -> None:
    diagnosis = diagnosed("explained").diagnosis
    gap = diagnosis.gap.model_copy(update={"before": 1.04, "after": 1.01, "closed_fraction": None, "interval": None})
    text = verdict_sentence(diagnosis.model_copy(update={"gap": gap}))
    assert text.endswith(
        "too small to show in predictions of held-out data: 1.04 before, 1.01 after, 1 without any gap."
    )


@pytest.mark.parametrize(("reason", "word"), [("time_limit", "time limit"), ("interrupted", "interrupted")])
def test_a_partial_result_says_what_ended_it_when_and_where(diagnosed: Diagnosed, reason: str, word: str) -> None:
    partial = {"reason": reason, "after": 61.3, "step": "single effects"}
    text = partial_sentence(diagnosed("explained").diagnosis.model_copy(update={"partial": Partial(**partial)}))
    for part in (word, "61.3 s", "single effects", "may be missing"):
        assert part in text
    assert partial_sentence(diagnosed("explained").diagnosis) == ""


def test_a_partial_result_names_what_was_left_out(diagnosed: Diagnosed) -> None:
    partial = Partial(reason="time_limit", after=61.3, step=ANSWERED, left_out=(BUDGET,))
    text = partial_sentence(diagnosed("explained").diagnosis.model_copy(update={"partial": partial}))
    assert BUDGET in text
    assert "may be missing" not in text


def test_a_partial_result_that_ended_before_any_step_names_none(diagnosed: Diagnosed) -> None:
    partial = Partial(reason="time_limit", after=61.3, step="")
    text = partial_sentence(diagnosed("explained").diagnosis.model_copy(update={"partial": partial}))
    assert "after 61.3 s, before its first step. Effects may be missing" in text


def test_a_result_that_only_lacks_the_next_experiment_has_all_causes(diagnosed: Diagnosed) -> None:
    partial = Partial(reason="time_limit", after=61.3, step=NEXT_EXPERIMENT)
    text = partial_sentence(diagnosed("ambiguous").diagnosis.model_copy(update={"partial": partial}))
    assert "search for causes was complete" in text


def test_a_partial_result_does_not_claim_that_no_effect_explains_the_gap(diagnosed: Diagnosed) -> None:
    partial = Partial(reason="time_limit", after=61.3, step="single effects")
    text = verdict_sentence(diagnosed("unknown_effect").diagnosis.model_copy(update={"partial": partial}))
    assert "no known effect" not in text
    assert "tried so far" in text


def test_causes_are_named_in_their_order(divided: Diagnosis) -> None:
    assert [cause.effect for cause in reported_causes(divided)] == ["hysteresis", "coulomb_friction"]
    sentence = verdict_sentence(divided)
    assert sentence.index("hysteresis") < sentence.index("Coulomb friction")


def test_names_that_hang_on_tolerances_are_in_the_verdict(guessed: Diagnosis) -> None:
    sentence = verdict_sentence(guessed)
    assert "hysteresis at motor_1 (with halved and stated ones)" in sentence
    assert "backlash at motor_1 (with doubled ones)" in sentence
    alone = guessed.model_copy(update={"ambiguity_groups": ()})
    assert "cannot distinguish" not in verdict_sentence(alone)
    assert "hysteresis at motor_1 (with halved" in verdict_sentence(alone)


def test_rivals_that_are_a_tie_with_any_tolerances_do_not_hang_on_them(guessed: Diagnosis) -> None:
    """47, 50 and 50 % against 53, 50 and 50 %: that the log does not tell them apart is said already."""
    hysteresis, backlash, coulomb = guessed.tolerance_sensitivity
    rows = (
        hysteresis.model_copy(update={"halved": 0.53, "stated": 0.4996, "doubled": 0.4988}),
        backlash.model_copy(update={"halved": 0.47, "stated": 0.5004, "doubled": 0.5012}),
        coulomb,
    )
    tie = guessed.model_copy(update={"tolerance_sensitivity": rows})
    assert tolerance_sentence(tie) == ""
    assert tolerance_lines(tie) == ()
    alone = tie.model_copy(update={"ambiguity_groups": ()})
    assert "hysteresis at motor_1 (with halved ones)" in tolerance_sentence(alone)


def test_names_of_a_part_that_hang_on_tolerances_are_in_the_verdict(divided: Diagnosis, guessed: Diagnosis) -> None:
    part = divided.model_copy(update={"tolerance_sensitivity": guessed.tolerance_sensitivity})
    assert "hysteresis at motor_1 (with halved and stated ones)" in verdict_sentence(part)


def test_a_cause_of_undetermined_size_is_not_named(divided: Diagnosis) -> None:
    hysteresis, coulomb = divided.causes
    unknown = hysteresis.model_copy(update={"determined": False})
    part = divided.model_copy(update={"causes": (unknown, coulomb)})
    assert [cause.effect for cause in reported_causes(part)] == ["coulomb_friction"]
    assert "hysteresis" not in verdict_sentence(part)


def test_what_closes_nothing_does_not_stand_before_what_closes_most(divided: Diagnosis) -> None:
    """An eccentricity of some size that closed nothing was named in place of friction whose size was not determined."""
    hysteresis, coulomb = divided.causes
    shares = [one.model_copy(update={"share_first": 0.0, "share_last": 0.0}) for one in divided.budget]
    shares[0] = divided.budget[0]
    steps = divided.waterfall[0].model_copy(update={"steps": divided.waterfall[0].steps[:1]})
    causes = (hysteresis.model_copy(update={"determined": False}), coulomb)
    part = divided.model_copy(update={"causes": causes, "budget": tuple(shares), "waterfall": (steps,)})
    assert [cause.effect for cause in reported_causes(part)] == ["hysteresis", "coulomb_friction"]


def test_the_floor_with_tolerance_stands_beside_the_floor(divided: Diagnosis) -> None:
    gap = divided.gap.model_copy(update={"tolerance_floor": 24.9})
    assert "floor 1, 24.9 with tolerance" in gap_line(gap)
    assert "24.9 with torques off by their tolerance" in verdict_sentence(divided.model_copy(update={"gap": gap}))


def test_a_rival_that_the_budget_lacks_is_not_named_as_a_cause(divided: Diagnosis) -> None:
    """The closed share that follows in the sentence is that of the repaired model."""
    hysteresis, coulomb = divided.causes
    rival = coulomb.model_copy(update={"effect": "backlash", "probability": 0.97})
    found = reported_causes(divided.model_copy(update={"causes": (rival, hysteresis, coulomb)}))
    assert [cause.effect for cause in found] == ["hysteresis", "coulomb_friction"]
