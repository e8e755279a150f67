"""Truths and answers for the tests of the score."""

from __future__ import annotations

from typing import Any

from flexros.gap.schema import Diagnosis
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.seal import Truth


def truth(kind: str, *places: str, gain: float = 1000.0, **other: Any) -> Truth:
    """Make a truth; places are written EFFECT@LOCATION."""
    split = [place.partition("@") for place in places]
    return Truth(
        name=other.pop("name", "case_0000"),
        kind=kind,
        robot=other.pop("robot", "e12"),
        size="any",
        nuisance=other.pop("nuisance", "exact"),
        tool=False,
        deviations=tuple(Deviation(effect=e, location=at, parameters={}) for e, _, at in split),
        gains=(gain,) * len(split),
        sample_time=5e-4,
        motion="random",
        conditions={},
        robot_sha256=other.pop("robot_sha256", ""),
        salt="salt",
    )


def diagnosis(
    verdict: str, *causes: str, probability: float = 0.9, groups: tuple[tuple[str, ...], ...] = ()
) -> Diagnosis:
    """Make a diagnosis; the first cause has the probability, the others share the rest."""

    def place(text: str) -> dict[str, Any]:
        effect, _, location = text.partition("@")
        return {"effect": effect, "location": location}

    rest = (1 - probability) / max(len(causes) - 1, 1)
    listed = [
        {**place(one), "probability": rest if number else probability, "parameters": {}, "closed_fraction": None}
        for number, one in enumerate(causes)
    ]
    gap = {"metric": "", "unit": "", "before": 2.0, "noise_floor": 1.0, "closed_fraction": 0.9 if causes else None}
    return Diagnosis.model_validate(
        {
            "schema": 2,
            "verdict": verdict,
            "causes": listed,
            "ambiguity_groups": [[place(one) for one in group] for group in groups],
            "where": [],
            "gap": gap,
            "next_experiment": None,
            "warnings": [],
            "provenance": {},
        }
    )


def answer(hidden: Truth, said: Diagnosis | None) -> Answer:
    """Put both together."""
    return Answer(hidden, said, 10.0)
