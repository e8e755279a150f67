"""The page of the hard pairs counts groups and separations, and reads the commands of proposed experiments."""

from __future__ import annotations

from typing import Any

import pytest

from flexros.effects import parse_effect
from flexros.errors import InputError
from flexros.gap.next_experiment.choose import command_of
from flexros.validation.campaigns.hard_pairs.page import is_grouped, is_separated, pair_sentence, pairs_page
from flexros.validation.campaigns.hard_pairs.pair_part import keys_of
from flexros.validation.campaigns.hard_pairs.settings import PAIRS, HardPairsSettings

PAIR = "delay, actuator_lag"


def answer(verdict: str, *causes: str, groups: tuple[tuple[str, ...], ...] = ()) -> dict[str, Any]:
    ambiguous = verdict == "ambiguous"
    return {
        "verdict": verdict,
        "causes": [[one, "motor_1", 0.6] for one in causes],
        "groups": [list(group) for group in groups],
        "experiment": "high_band" if ambiguous else None,
        "expected_gain": 120.0 if ambiguous else None,
        "command": None,
    }


GROUP = answer("ambiguous", "actuator_lag", "delay", groups=(("actuator_lag", "delay"),))
SEPARATED = {"truth": "delay@motor_1:time=0.0001", "first": GROUP, "second": answer("explained", "delay")}
WRONG = {**SEPARATED, "second": answer("explained", "actuator_lag")}
NAMED = {**SEPARATED, "first": answer("explained", "delay"), "second": None}


def test_what_was_separated_is_what_the_second_log_named_rightly() -> None:
    assert is_grouped(PAIR, SEPARATED)
    assert not is_grouped("backlash, hysteresis", SEPARATED)
    assert [is_separated(part) for part in (SEPARATED, WRONG, NAMED)] == [True, False, False]


def test_the_sentence_counts_and_the_page_shows_every_truth() -> None:
    text = pair_sentence(PAIR, [SEPARATED, WRONG, NAMED])
    assert text == (
        "Of 3 first logs 3 showed a gap; 2 left both effects in a group, and the proposed experiment separated 1 of "
        "these. In 1 the first log alone named the right effect."
    )
    page = pairs_page({PAIR: [SEPARATED, NAMED]}, HardPairsSettings(), {"flexros": "0"})
    assert "| `delay@motor_1:time=0.0001` | ambiguous | actuator_lag 60 %, delay 60 % | actuator_lag, delay |" in page
    assert "high_band (120 nats) | explained | delay 60 % |" in page


def test_a_command_gives_the_keys_that_made_it() -> None:
    keys = {"diagnosis.parts": ["multisine"], "diagnosis.highest": 600.0, "model.values.body_3.mass": 150.0}
    assert keys_of(command_of(keys, "four_mass_linear", 7)) == {**keys, "robot": "four_mass_linear", "seed": 7}
    with pytest.raises(InputError, match="'make coffee' does not run the diagnosis experiment; give the command"):
        keys_of("make coffee")


def test_every_truth_is_an_effect_of_its_pair() -> None:
    for pair, truths in PAIRS.items():
        assert {parse_effect(truth, "test").effect.name for truth in truths} == set(pair.split(", "))
