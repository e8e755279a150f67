"""Page of results of the nulls with rounded encoders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.score.answer import REFUSED
from flexros.validation.blind.score.statistics import share
from flexros.validation.campaigns.markdown import logs_without_answer, table, version_line

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.blind.score.statistics import Share
    from flexros.validation.campaigns.blind_campaign import ScoredCases
    from flexros.validation.campaigns.quantized_nulls.settings import QuantizedNullsSettings

GOAL = 0.01
"""Largest share of nulls that may be called anything but `no_gap` (requirement)."""
COARSE = 0.3
"""Step over noise from which encoders count as coarse in the table [1]; the middle of 0.1 to 1 in the logarithm."""
CAUSES = 4
"""Causes that are listed of a false alarm."""
STEP, COLOUR = "encoder_step", "colour"
"""Keys of the step of the encoders and the colour of their noise among the conditions of a truth."""


def alarmed(one: Answer) -> bool:
    """Whether a null was called anything but `no_gap`; a log that was refused counts as well."""
    return one.diagnosis is None or one.alarm


def false_alarms(answers: Sequence[Answer]) -> Share:
    """Count the nulls that were called anything but `no_gap`."""
    return share(alarmed(one) for one in answers)


def groups(answers: Sequence[Answer]) -> dict[str, list[Answer]]:
    """Divide cases by nominal model, robot, and noise and step of the encoders."""

    def by(key: Callable[[Answer], str]) -> dict[str, list[Answer]]:
        return {name: [one for one in answers if key(one) == name] for name in sorted({key(one) for one in answers})}

    return {
        **by(lambda one: _nominal(one.truth.nuisance)),
        **by(lambda one: one.truth.robot),
        **by(lambda one: "coloured noise" if one.truth.conditions.get(COLOUR) else "white noise"),
        **by(lambda one: f"step {'from' if _step(one) >= COARSE else 'below'} {COARSE:g} of the noise"),
    }


def nulls_page(found: ScoredCases, settings: QuantizedNullsSettings) -> str:
    """Write the page.

    Args:
        found: The cases as scored.
        settings: Settings of the campaign.

    Returns:
        Markdown.
    """
    answers = found.answers
    lines = ["# Nulls with rounded encoders", "", *_introduction(answers, found.planned, settings), ""]
    lines += [*_verdict(found), ""]
    shown = {"all": answers, **groups(answers)}
    lines += table(
        ("logs", "called anything but `no_gap`", "largest gap over its floor", "median time of a diagnosis [s]"),
        [(name, str(false_alarms(some)), *_figures(some)) for name, some in shown.items()],
    )
    lines += ["", "## False alarms", ""]
    wrong = [one for one in answers if alarmed(one)]
    headings = (
        "case", "robot", "nominal model", "motion", "colour of noise", "step / noise", "verdict", "gap / floor",
        "named, probability", "without rounding",
    )  # fmt: skip
    lines += table(headings, [_case(one, found.controls.get(one.truth.name)) for one in wrong]) if wrong else ["None."]
    lines += [*logs_without_answer(found.failures), "", f"{version_line(found.used)}."]
    return "\n".join(lines) + "\n"


def nulls_summary(answers: Sequence[Answer], planned: int) -> tuple[str, ...]:
    """Return the result in sentences.

    Args:
        answers: The cases as scored.
        planned: Number of cases of the whole plan.
    """
    return (f"{len(answers)} of {planned} planned nulls; called anything but `no_gap`: {false_alarms(answers)}.",)


def _introduction(answers: Sequence[Answer], planned: int, settings: QuantizedNullsSettings) -> list[str]:
    low, high = settings.encoder_steps
    fit, holdout, _ = settings.durations
    return [
        f"Written by `flexros campaign quantized_nulls --repetitions {len(answers)}`: the first {len(answers)} of "
        f"{planned} planned cases, seed {settings.seed} of the evaluation stream, which was not used in development. "
        "Every case is a robot without any hidden deviation, simulated by the independent plant of the blind check. "
        f"Its encoders round their noisy positions to a step of {low:g} to {high:g} of the noise (drawn evenly in the "
        "logarithm, the same multiple at all motors); controller and log get the rounded ones. The diagnosis gets a "
        f"log of {fit:g} s, a second one of {holdout:g} s, and a nominal model that states the noise, not the step, "
        "with the settings of the blind check. In half of the cases the model is exact; in the others it is off "
        "within its tolerance (3 % of stiffness and inertia, 30 % of damping), with the coloured noise, jitter and "
        "late poses of the blind check. Shares have 95 % intervals (Wilson). Every false alarm is made and diagnosed "
        "once more without rounding, all else being equal.",
    ]


def _verdict(scored: ScoredCases) -> list[str]:
    found = false_alarms(scored.answers)
    refused = sum(one.diagnosis is None for one in scored.answers)
    words = f"**Called anything but `no_gap`: {found}; goal at most {100 * GOAL:g} %.**"
    if refused:
        words += f" {refused} of these logs {'was' if refused == 1 else 'were'} refused."
    if found.cases and found.high > GOAL >= found.value:
        words += (
            f" The share meets the goal; so few logs do not show it with confidence, since the interval reaches "
            f"{100 * found.high:.1f} %."
        )
    elif found.value > GOAL:
        words += " The goal is missed."
        if found.low <= GOAL:
            words += " The interval holds the goal: more logs would tell."
    if scored.controls:
        same = sum(map(alarmed, scored.controls.values()))
        words += (
            f" Without rounding {same} of the {len(scored.controls)} are called so as well: these do not come from "
            "the encoders."
        )
    return [words]


def _figures(answers: Sequence[Answer]) -> tuple[str, str]:
    ratios = [value for value in map(_ratio, answers) if value is not None]
    seconds = [one.seconds for one in answers if one.seconds is not None]
    return f"{max(ratios):.3f}" if ratios else "", f"{np.median(seconds):.1f}" if seconds else ""


def _case(one: Answer, control: Answer | None) -> tuple[str, ...]:
    truth, ratio = one.truth, _ratio(one)
    return (
        truth.name,
        truth.robot,
        _nominal(truth.nuisance),
        f"{truth.motion}, {1e3 * truth.sample_time:g} ms",
        f"{truth.conditions.get(COLOUR, 0.0):.2f}",
        f"{_step(one):.2f}",
        _said(one),
        "" if ratio is None else f"{ratio:.3f}",
        _named(one) or "nothing",
        "" if control is None else ", ".join(filter(None, (_said(control), _named(control)))),
    )


def _said(one: Answer) -> str:
    return REFUSED if one.diagnosis is None else one.diagnosis.verdict


def _named(one: Answer) -> str:
    named = [f"{cause.effect} {cause.location} {cause.probability:.2f}" for cause in one.causes[:CAUSES]]
    further = len(one.causes) - CAUSES
    return "; ".join([*named, f"{further} more"] if further > 0 else named)


def _ratio(one: Answer) -> float | None:
    gap = None if one.diagnosis is None else one.diagnosis.gap
    return gap.before / gap.noise_floor if gap is not None and gap.noise_floor else None


def _step(one: Answer) -> float:
    return one.truth.conditions.get(STEP, 0.0)


def _nominal(nuisance: str) -> str:
    names: Mapping[str, str] = {
        "exact": "nominal exact",
        "tolerance_1": "nominal 1 % off",
        "tolerance_3": "nominal 3 % off",
    }
    return names[nuisance]
