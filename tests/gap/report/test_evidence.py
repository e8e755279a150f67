"""What speaks for an effect and against it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexros.gap.report.evidence import EvidenceSection, speaks_against, speaks_for
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import EffectLocation

Diagnosed = Callable[[str], DiagnosisResult]


def test_the_first_effect_has_its_gain_on_both_logs(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    told = " ".join(speaks_for(result.ranking[0], result))
    assert "by 5400, its parameters cost 22" in told
    assert "not seen better: gain 2160 there" in told
    assert "leaves under 1 % of the excess" in told


def test_only_numbers_clear_of_zero_speak_for_it(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    assert "Clearly different from zero: level 0.213 Nm (±0.011)." in speaks_for(result.ranking[0], result)
    assert not any("asymmetry" in text for text in speaks_against(result.ranking[0], result))


def test_a_size_near_zero_and_an_unknown_number_speak_against(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    first = result.ranking[0]
    level, asymmetry = first.parameters["level"], first.parameters["asymmetry"]
    numbers = {
        "level": level.model_copy(update={"std": 0.2}),
        "asymmetry": asymmetry.model_copy(update={"std": np.inf}),
    }
    told = speaks_against(replace(first, parameters=numbers), result)
    assert "Not determined by this log: asymmetry." in told
    assert "Its size is hardly different from zero: level 0.21 Nm (±0.20)." in told


def test_a_rival_is_told_how_far_it_is_behind_and_what_it_leaves(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    told = speaks_against(result.ranking[2], result)
    assert "Coulomb friction at motor_1 gains 3489 more." in told
    assert "It leaves 60 % of the excess over the noise floor unexplained." in told


def test_effects_of_a_pair_are_judged_together(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    backlash = EffectLocation(effect="backlash", location="motor_1")
    first = replace(result.ranking[0], together_with=(backlash,))
    pair = replace(result, ranking=(first, *result.ranking[1:]))
    assert any(text.startswith("Together with backlash at motor_1 it raises") for text in speaks_for(first, pair))
    assert "Coulomb friction at motor_1 and backlash at motor_1 gain 200 more." in speaks_against(pair.ranking[1], pair)


def test_an_effect_that_gains_too_little_is_told_so(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    assert "Its gain of -4 does not pay for its parameters (11)." in speaks_against(result.ranking[3], result)


def test_effects_of_a_group_name_each_other(diagnosed: Diagnosed) -> None:
    result = diagnosed("ambiguous")
    assert "This log cannot tell it from backlash at motor_1." in speaks_against(result.ranking[0], result)
    assert "This log cannot tell it from hysteresis at motor_1." in speaks_against(result.ranking[1], result)


def test_an_effect_that_does_not_predict_is_told_so(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    useless = replace(result.ranking[0], holdout_gain=-3.0)
    assert any("does not predict the data" in text for text in speaks_against(useless, result))


def test_without_a_gap_there_is_no_evidence(diagnosed: Diagnosed) -> None:
    assert EvidenceSection().blocks(diagnosed("no_gap")) == ()
