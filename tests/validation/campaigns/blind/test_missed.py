"""The list of what was missed."""

from __future__ import annotations

import pytest

from flexros.gap.schema import CauseParameter
from flexros.validation.blind.score.answer import Answer
from flexros.validation.campaigns.blind.missed import missed_cases, missed_sizes
from tests.validation.blind.cases import answer, diagnosis, truth

FRICTION, DELAY, LAG = "coulomb_friction@motor_1", "delay@motor_2", "actuator_lag@motor_2"
GROUP = (DELAY, LAG)


@pytest.mark.parametrize(
    ("one", "why"),
    [
        (answer(truth("null"), diagnosis("no_gap")), ""),
        (answer(truth("null"), diagnosis("unknown_effect")), "false alarm"),
        (answer(truth("null"), None), "refused"),
        (answer(truth("single", DELAY), diagnosis("explained", DELAY)), ""),
        (answer(truth("single", DELAY), diagnosis("explained", FRICTION, DELAY)), "another effect first"),
        (answer(truth("single", DELAY), diagnosis("ambiguous", LAG, DELAY, groups=(GROUP,))),
         "ambiguous, another effect first"),
        (answer(truth("single", DELAY), diagnosis("unknown_effect", DELAY)), "reported as unknown"),
        (answer(truth("single", DELAY), diagnosis("no_gap")), "not detected"),
        (answer(truth("single", DELAY, gain=20.0), diagnosis("no_gap")), ""),
        (answer(truth("unknown", "cable@motor_1"), diagnosis("unknown_effect")), ""),
        (answer(truth("unknown", "cable@motor_1"), diagnosis("explained", FRICTION)), "a known effect is named"),
        (answer(truth("pair", FRICTION, DELAY), diagnosis("explained", DELAY, FRICTION)), ""),
        (answer(truth("pair", FRICTION, DELAY), diagnosis("explained", LAG, FRICTION)), "one of the two is missing"),
        (answer(truth("pair", FRICTION, DELAY), diagnosis("explained", LAG)), "both are missing"),
    ],
)  # fmt: skip
def test_every_kind_of_miss_has_its_words(one: Answer, why: str) -> None:
    assert one.missed == why


def test_a_row_tells_what_was_hidden_and_what_was_said() -> None:
    right = answer(truth("null"), diagnosis("no_gap"))
    wrong = answer(truth("single", DELAY, name="case_0007"), diagnosis("explained", FRICTION, DELAY))
    _, _, row = missed_cases([right, wrong])
    assert row == (
        "| case_0007 | e12 | exact | random, 0.5 ms | delay motor_2 1e+03 | coulomb_friction motor_1 0.90; "
        "delay motor_2 0.10 | another effect first |"
    )


@pytest.mark.parametrize(("value", "rows"), [(3.1e-3, 0), (3.3e-3, 1)])
def test_a_size_outside_its_interval_is_listed_with_its_distance(value: float, rows: int) -> None:
    hidden = truth("single", DELAY)
    (what,) = hidden.deviations
    hidden = hidden.model_copy(update={"deviations": (what.model_copy(update={"parameters": {"time": 3e-3}}),)})
    said = diagnosis("explained", DELAY)
    size = CauseParameter(value=value, std=1e-4, unit="s")
    said = said.model_copy(update={"causes": (said.causes[0].model_copy(update={"parameters": {"time": size}}),)})
    found = missed_sizes([answer(hidden, said)])[2:]
    assert found == ["| case_0000 | e12 | delay | time | 0.003 | 0.0033 s | 3.0 |"][:rows]
