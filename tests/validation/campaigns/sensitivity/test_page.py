"""The page of the sensitivity study counts what moved."""

from __future__ import annotations

from typing import Any

from flexros.validation.campaigns.sensitivity.page import Study, effects_of, sensitivity_page, sensitivity_summary
from flexros.validation.campaigns.sensitivity.settings import CASES, FACTORS

NO_GAP = {"verdict": "no_gap", "cause": None, "location": None, "probability": None, "closed_fraction": None}


def _found(verdict: str = "explained", probability: float = 0.9, effect: str = "backlash") -> dict[str, Any]:
    return {
        "verdict": verdict, "cause": effect, "location": "motor_1", "probability": probability, "closed_fraction": 0.5
    }  # fmt: skip


STUDY = Study(
    cases=CASES[1:3],
    values={"calm": 2.0, "level": 1e-4, "bands": (1.0, 2.0)},
    factors=FACTORS,
    answers={
        "case_0002": {
            "": [NO_GAP],
            "calm": [NO_GAP, NO_GAP],
            "level": [NO_GAP, _found("unknown_effect", 0.2)],
            "bands": [{"refused": "not allowed"}, NO_GAP],
        },
        "case_0003": {
            "": [_found()],
            "calm": [_found(probability=0.8), _found()],
            "level": [_found("ambiguous", effect="hysteresis"), _found()],
            "bands": [_found(), _found()],
        },
    },
)


def test_settings_that_move_verdicts_come_first() -> None:
    level, calm, bands = effects_of(STUDY)
    assert (level.key, level.answers, level.verdicts, level.causes) == ("level", 4, 2, 2)
    assert (calm.key, calm.verdicts, round(calm.probability, 6)) == ("calm", 0, 0.1)
    assert (bands.key, bands.answers, bands.verdicts) == ("bands", 3, 0)
    assert sensitivity_summary(STUDY) == (
        "1 of 3 settings change a verdict or a first cause in some of 11 answers; 2 verdicts are others.",
    )


def test_page_lists_defaults_settings_and_changed_answers() -> None:
    page = sensitivity_page(STUDY, {"flexros": "1"})
    assert (
        "| case_0003 | four_mass_linear | coulomb_friction | medium | exact | explained | backlash at motor_1 |" in page
    )
    assert "| `level` | 0.0001 | 4 | 2 | 2 | 0.000 | 0.000 |" in page
    assert "| `level` | 2 | case_0002 | no_gap | unknown_effect, backlash at motor_1, 0.200 |" in page
    assert "| `bands` | 0.5 | case_0002 | no_gap | not allowed |" in page
    assert "`calm` | 0.5" not in page
