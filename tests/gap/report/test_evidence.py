"""Evidence for and against an effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexros.gap.report.evidence import (
    EvidenceSection,
    evidence_against,
    evidence_for,
    explanation_against,
    explanation_for,
)
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import Diagnosis, EffectLocation
from flexros.report.base import Folded, Heading, Paragraph

Diagnosed = Callable[[str], DiagnosisResult]


def test_the_first_effect_has_its_gain_on_both_logs(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    told = " ".join(explanation_for(result.ranking[0]))
    assert "by 5400, its parameters cost 22" in told
    assert "held-out data better: gain 2160" in told
    assert "leaves under 1 % of the excess" in told


def test_only_numbers_clear_of_zero_speak_for_it(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    assert "Clearly different from zero: level 0.213 Nm (±0.011)." in evidence_for(result.ranking[0], result)
    assert not any("asymmetry" in text for text in evidence_against(result.ranking[0], result))


def test_a_size_near_zero_and_an_unknown_number_speak_against(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    first = result.ranking[0]
    level, asymmetry = first.parameters["level"], first.parameters["asymmetry"]
    numbers = {
        "level": level.model_copy(update={"std": 0.2}),
        "asymmetry": asymmetry.model_copy(update={"std": np.inf}),
    }
    told = evidence_against(replace(first, parameters=numbers), result)
    assert "Not identifiable from this log: asymmetry." in told
    assert "Its size is hardly different from zero: level 0.21 Nm (±0.20)." in told


def test_a_rival_is_reported_with_its_distance_and_remainder(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    told = explanation_against(result.ranking[2], result)
    assert "Coulomb friction at motor_1 gains 3489 more." in told
    assert "It leaves 60 % of the excess over the noise floor unexplained." in told


def test_effects_of_a_pair_are_judged_together(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    backlash = EffectLocation(effect="backlash", location="motor_1")
    first = replace(result.ranking[0], together_with=(backlash,))
    pair = replace(result, ranking=(first, *result.ranking[1:]))
    assert any(text.startswith("Together with backlash at motor_1 it raises") for text in explanation_for(first))
    told = explanation_against(pair.ranking[1], pair)
    assert "Coulomb friction at motor_1, together with backlash at motor_1, gains 200 more." in told


def test_many_effects_that_act_together_are_counted(diagnosed: Diagnosed) -> None:
    first = diagnosed("explained").ranking[0]
    others = tuple(EffectLocation(effect="viscous_friction", location=f"motor_{k}") for k in range(1, 6))
    told = explanation_for(replace(first, together_with=others))
    assert told[0].startswith("Together with the 5 other effects of its explanation it raises")


def test_further_causes_are_folded(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    causes = tuple(replace(result.ranking[0], location=f"motor_{k}") for k in range(1, 6))
    blocks = EvidenceSection().blocks(replace(result, ranking=causes))
    assert sum(isinstance(block, Folded) for block in blocks) == 2


def test_what_is_common_to_an_explanation_is_said_once(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    first, second = result.ranking[:2]
    others = [EffectLocation(effect=one.effect, location=one.location) for one in (second, first)]
    pair = tuple(replace(one, gain=5400.0, together_with=(other,)) for one, other in zip((first, second), others))
    blocks = EvidenceSection().blocks(replace(result, ranking=pair))
    assert blocks[0] == Heading("The explanation by 2 effects")
    assert sum("5400" in block.text for block in blocks if isinstance(block, Paragraph)) == 1


def test_what_opens_without_an_effect_is_its_own_evidence(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    result = replace(diagnosed("explained"), diagnosis=divided)
    assert "Without it, and with all others, 20 % of the held-out gap opens." in evidence_for(result.ranking[0], result)


def test_too_little_gain_is_reported(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    assert "Its gain of -4 does not justify its parameters (11)." in explanation_against(result.ranking[3], result)


def test_effects_of_a_group_name_each_other(diagnosed: Diagnosed) -> None:
    result = diagnosed("ambiguous")
    assert "This log cannot distinguish it from backlash at motor_1." in evidence_against(result.ranking[0], result)
    assert "This log cannot distinguish it from hysteresis at motor_1." in evidence_against(result.ranking[1], result)


def test_an_effect_that_does_not_predict_held_out_data_is_reported(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    useless = replace(result.ranking[0], holdout_gain=-3.0)
    assert any("does not predict held-out data" in text for text in explanation_against(useless, result))


def test_without_a_gap_there_is_no_evidence(diagnosed: Diagnosed) -> None:
    assert EvidenceSection().blocks(diagnosed("no_gap")) == ()
