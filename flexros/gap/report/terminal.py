"""The answer of a diagnosis for a terminal, in the words of the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.report.budget import (
    LITTLE_WORSE,
    WHY_NEEDED,
    WHY_WORSE,
    WORSE_ALONE,
    WORSE_WITHOUT,
    draws,
    is_worse_alone,
    is_worse_without,
)
from flexros.gap.report.figure_words import (
    band_words,
    floors_words,
    gap_closed_words,
    gap_words,
    interval_words,
    p_value_words,
    share_interval_words,
    share_words,
    shows,
    signed_share_words,
)
from flexros.gap.report.ranking import first_of_explanations, first_of_ranking
from flexros.gap.report.verdict import hanging_names, verdict_sentence
from flexros.gap.report.waterfall import waterfall_lines
from flexros.gap.report.words import budget_words, capital, clear_words, first_few, named, number_words, where_words
from flexros.gap.search.better_torques import LEAST
from flexros.gap.where.regimes import REGIMES
from flexros.report.number_text import number

if TYPE_CHECKING:
    from rich.table import Table

    from flexros.gap.held_out.left_over import LeftOver
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import BudgetShare, Diagnosis, GapNumbers

_RANKED, _LOCATIONS, _MOTIONS, _NUMBERS = 6, 3, 2, 4
"""Number of effects, of locations, of motions of the rest of a joint, and of motors and bodies with wrong numbers that
are printed (chosen)."""


def verdict_line(diagnosis: Diagnosis) -> str:
    """Return the verdict: its word and its sentence."""
    return f"{diagnosis.verdict}: {verdict_sentence(diagnosis)}"


def ranking_table(result: DiagnosisResult) -> Table:
    """Return a table of the first effects in their order, of all further causes and rivals, and of 'nothing'.

    Gain and remainder are those of a whole explanation, and are written at the first of its effects.
    """
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("effect", min_width=20)
    for heading in ("probability", "gain", "leaves"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("fitted (± std)", min_width=22)
    ranked = first_of_ranking(result, _RANKED)
    for candidate, first in zip(ranked, first_of_explanations(ranked), strict=True):
        left = "-" if candidate.remainder is None else share_words(candidate.remainder)
        figures = (number(candidate.score, 4), left) if first else ("", "")
        cells = (capital(named(candidate)), share_words(candidate.probability), *figures)
        table.add_row(*map(Text, (*cells, clear_words(candidate.effect, candidate.parameters))))
    table.add_row("Nothing", share_words(result.null_probability), "0", "100 %", "")
    return table


def where_lines(result: DiagnosisResult) -> tuple[str, ...]:
    """Describe the first locations of the gap."""
    return tuple(
        f"{where_words(location, result.record.sample_time)}, {p_value_words(location.p_value, result.simulated_logs)}"
        for location in result.diagnosis.where[:_LOCATIONS]
    )


def budget_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Write the waterfall of each joint and the shares of the effects; nothing for a single effect that leaves none."""
    if not draws(diagnosis):
        return ()
    effects = [share for share in diagnosis.budget if share.effect is not None]
    shares = [f"{capital(_with_class(share))}: {_last_words(share)}, {_first_words(share)}" for share in effects]
    why = [f"{capital(WORSE_WITHOUT)}: {WHY_NEEDED}"] if any(map(is_worse_without, effects)) else []
    why += [f"{capital(WORSE_ALONE)}: {WHY_WORSE}"] if any(map(is_worse_alone, effects)) else []
    return (*waterfall_lines(diagnosis), *shares, *why)


def _last_words(share: BudgetShare) -> str:
    return WORSE_WITHOUT if is_worse_without(share) else f"{_share(share.share_last, share.interval_last)} removed last"


def _first_words(share: BudgetShare) -> str:
    return WORSE_ALONE if is_worse_alone(share) else f"{_share(share.share_first, share.interval)} added first"


def number_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """List the numbers of the model that the log contradicts, a line for each motor, body or load: all it lacks first.

    Returns:
        E.g. "tool_load: mass 0.956 kg (±0.039), x 0.020 m (±0.005)", "body_5: inertia.xy -0.00243 kg m2 (±0.00015)
        instead of -0.002117".
    """
    lacked: dict[str, list[str]] = {}
    wrong: dict[str, list[str]] = {}
    for one in diagnosis.model_numbers:
        owner, _, name = one.name.partition(".")
        size = number_words(one)
        instead = f" instead of {number(one.nominal, 4)}" if one.nominal else ""
        (wrong if one.nominal else lacked).setdefault(owner, []).append(f"{name} {size}{instead}")
    lines = [f"{owner}: {', '.join(texts)}" for found in (lacked, wrong) for owner, texts in found.items()]
    shown = len(lacked) + _NUMBERS
    more = [f"and those of {len(lines) - shown} more, in report and patch"] if len(lines) > shown else []
    return (*lines[:shown], *more)


def rest_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Say at which joint, in which motion and in which band the unexplained rest is; nothing without a budget."""
    if not draws(diagnosis):
        return ()
    lines = []
    for rest in (one for one in diagnosis.unexplained if one.regime == "all"):
        motions = [one for one in diagnosis.unexplained if one.joint == rest.joint and one.regime != "all"]
        where = [f"{REGIMES[one.regime].phrase} {share_words(one.share)}" for one in motions[:_MOTIONS]]
        band = max(rest.bands, key=lambda one: one.share, default=None)
        if band is not None:
            where.append(f"{band_words(band.band_hz)} {share_words(band.share)}")
        lines.append(f"{rest.joint}: {share_words(rest.share)}{': ' if where else ''}{', '.join(where)}")
    return tuple(lines)


def _with_class(share: BudgetShare) -> str:
    """Write an effect with its class, e.g. "hysteresis at motor_1 (gear)", where its name does not say that."""
    words = budget_words(share)
    return words if share.cause_class in words else f"{words} ({share.cause_class})"


def _share(share: float | None, interval: tuple[float, float] | None) -> str:
    """Write a share with its 95 % interval, e.g. "91 % (85 % to 96 %)", "−8 % (worse, −12 % to −4 %)"."""
    if share is None:
        return "-"
    within = share_interval_words(interval)
    if share > LITTLE_WORSE:
        return share_words(share) + within
    return f"{signed_share_words(share)} (worse{within.replace(' (', ', ').removesuffix(')')})"


def gap_line(gap: GapNumbers) -> str:
    """Return the gap in one line."""
    unit = "" if gap.unit in ("", "1") else f" {gap.unit}"
    closely = "" if gap.before_alone is None else f" ({gap_words(gap.before_alone, 4)} as flexros gap states it)"
    parts = [f"{gap_words(gap.before, 4)}{unit} before{closely}", floors_words(gap)]
    if gap.after is not None:
        parts.insert(1, f"{gap_words(gap.after, 4)} after")
    if gap.best_rival is not None:
        parts.append(f"best rival {gap_words(gap.best_rival, 4)}")
    if gap.closed_fraction is not None and shows(gap):
        parts.append(f"{gap_closed_words(gap)} closed{interval_words(gap.interval)}")
    return f"Gap ({gap.metric}): {', '.join(parts)}"


def other_figures_line(diagnosis: Diagnosis, log: str, gap: GapNumbers) -> str:
    """Say why the gap of a log is another one in a diagnosis that held it out; empty where that is no question.

    Args:
        diagnosis: The diagnosis.
        log: Name of the log.
        gap: Its gap as `flexros gap` measures it, with the patch of that diagnosis.
    """
    fitted, held, stated = diagnosis.provenance.get("log"), diagnosis.provenance.get("holdout"), diagnosis.gap
    figures = [[gap_words(one.before, 4), gap_words(one.after or one.before, 4)] for one in (stated, gap)]
    if held != log or figures[0] == figures[1]:
        return ""
    alone = fitted == held
    which, here = ("its last part", "all of it") if alone else ("this log", "this log")
    return (
        f"The diagnosis of {fitted} states {figures[0][0]} before and {figures[0][1]} after for {which}: there the "
        "numbers that the model tolerates, noise, rate and time of the torques are those of the fitted "
        f"{'part' if alone else 'log'}, here those of {here}. Compare figures of one command"
    )


def gap_verdict(left: LeftOver, model: str) -> str:
    """Say whether a model leaves a gap.

    Args:
        left: What it leaves.
        model: What it is called.
    """
    if left.moving_on and not left.beyond:
        motors = ", ".join(left.moving_on)
        return f"a gap: {model} predicts {motors} hardly better than at constant speed, by a far larger inertia"
    if left.significant:
        return f"a gap: the errors of {model} are more than noise and tolerance"
    allowed = f"{gap_words(left.most_of_machine)} times " if left.most_of_machine and left.level > left.most else ""
    return f"no gap: the errors of {model} are no more than {allowed}noise and tolerance"


def left_line(left: LeftOver) -> str:
    """Return in one line what decides whether a model leaves a gap, with its bound."""
    text = (
        "Decides (mean squared prediction error one sample ahead over its floor variance): "
        f"{gap_words(left.level, 4)}, up to {gap_words(left.most, 4)} is noise and tolerance"
    )
    if left.most_of_machine is not None:
        text += (
            f", or up to {gap_words(left.most_of_machine)} where the gap 0.1 s ahead, {gap_words(left.ahead)} here, is "
            f"at most {gap_words(left.most_ahead)}"
        )
        if left.refused:
            text += f" and no number of the model is far out of its tolerance, as {', '.join(left.strained)} is"
    if left.lacking:
        text += f"; the model lacks the rounding of the encoder of {', '.join(left.lacking)}, which is a gap"
    return text


def hidden_line(left: LeftOver) -> str:
    """Return in one sentence what an assumed tolerance of torques hides; empty where it hides nothing that is known."""
    if left.assumed is None or left.if_known is None:
        return ""
    return (
        f"That torques are known within {100 * left.assumed:g} % of their rms is assumed, not measured: known within "
        f"{100 * LEAST:g} %, as those of a simulator, they show a gap of {gap_words(left.if_known, 4)}. Diagnose the "
        f"log, which finds out how well they are known, or state a tolerance of torque of {LEAST:g}"
    )


def group_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """List the groups of effects that the log cannot distinguish."""
    return tuple(
        f"Not distinguishable: {first_few([named(location) for location in group], most=6)}"
        if len(group) > 1
        else f"Not decided: whether there is {named(group[0])}"
        for group in diagnosis.ambiguity_groups
    )


def tolerance_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """List the effects whose names hang on halved or doubled tolerances, or say that no name changes."""
    rows = diagnosis.tolerance_sensitivity
    changing = tuple(
        f"{capital(named(row))}: {share_words(row.halved)} with halved tolerances of the model, "
        f"{share_words(row.stated)} with the stated ones, {share_words(row.doubled)} with doubled ones"
        for row in hanging_names(diagnosis)
    )
    if changing or any(row.changes for row in rows):
        return changing
    return ("No name changes with halved or doubled tolerances of the model",) if rows else ()


def next_lines(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the experiment to run next, and its command."""
    experiment = diagnosis.next_experiment
    if experiment is None:
        return ()
    line = f"Next experiment: {experiment.name}, {experiment.description.rstrip('.')}"
    return (line, f"  {experiment.command}") if experiment.command else (line,)
