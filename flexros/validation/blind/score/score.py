"""Scoring a blind check: opening the truths and counting."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.gap.schema import Diagnosis
from flexros.validation.blind.diagnose_case import FAILURE_FILE, TIME_FILE, case_folders
from flexros.validation.blind.score.answer import VISIBLE, Answer
from flexros.validation.blind.score.coverage import fitted_sizes
from flexros.validation.blind.score.crowd_tables import crowd_groups
from flexros.validation.blind.score.crowd_truth import crowd_truth
from flexros.validation.blind.score.crowds import crowd_score
from flexros.validation.blind.score.oracle import oracle_fraction
from flexros.validation.blind.score.statistics import (
    Calibration,
    DetectionCurve,
    Share,
    calibration,
    detection_curve,
    median,
    share,
)
from flexros.validation.blind.score.third_log import third_log
from flexros.validation.blind.seal import DIAGNOSIS_FILE, ROBOT_FILE, read_case, read_truth

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

MOST = 0.95
"""Share of the gap of a third log that a patch must close to be counted as closing it [1] (chosen)."""


def read_answers(logs: Path, truths: Path, oracle: bool = False) -> list[Answer]:
    """Read all cases that were diagnosed, and check their seals.

    Args:
        logs: Folder of all logs, with their diagnoses.
        truths: Folder of all truths.
        oracle: Whether the true structure is fitted, and the patch held against the third log, where the logs are
            still there.

    Returns:
        The cases, by name.

    Raises:
        InputError: A truth or a nominal model was changed, or nothing was diagnosed yet.
    """
    answers = []
    for folder in case_folders(logs):
        if not any((folder / name).exists() for name in (DIAGNOSIS_FILE, FAILURE_FILE)):
            continue
        case = read_case(folder)
        truth = read_truth(case, truths, (folder / ROBOT_FILE).read_bytes())
        fitted = oracle and all((folder / log).exists() for log in case.logs[:2])
        closed = oracle_fraction(folder, case, truth) if fitted else None
        third = third_log(folder, case) if oracle and (folder / case.logs[2]).exists() else None
        crowd = crowd_truth(folder, case, truth) if fitted and (folder / case.logs[2]).exists() else None
        answers.append(Answer(truth, _diagnosis(folder), _seconds(folder), closed, third, crowd))
    if not answers:
        raise InputError(f"no case in '{logs}' is diagnosed yet; run `flexros blind run {logs}` first")
    return answers


def _diagnosis(folder: Path) -> Diagnosis | None:
    file = folder / DIAGNOSIS_FILE
    return Diagnosis.model_validate_json(file.read_bytes()) if file.exists() else None


def _seconds(folder: Path) -> float | None:
    file = folder / TIME_FILE
    return float(file.read_text(encoding="utf-8")) if file.exists() else None


@dataclass(frozen=True)
class Score:
    """Figures of a set of cases; "visible" are those well above the noise.

    Attributes:
        cases: Number of cases.
        top_1: Visible single effects whose name comes first.
        top_1_nested: The same, an effect that holds the true one as a special case counted as right.
        top_3: Visible single effects among the first three.
        in_group: Visible single effects that come first or in the ambiguity group of the first.
        group_size: Mean size of the ambiguity groups of visible single effects.
        location: Of visible single effects with the right name (nested ones too), those with the right location.
        detected: Visible single effects of which a gap was detected.
        false_alarms: Logs without deviation in which a gap was claimed.
        unknown_found: Causes outside the library that were reported as unknown.
        unknown_seen: Causes outside the library of which a gap was detected.
        known_unknown: Visible effects of the library, single or in pairs, that were reported as unknown.
        pairs: Pairs, both visible, whose names both are the first two.
        pairs_nested: The same with nested effects counted.
        refused: Logs that the diagnosis refused.
        covered: Correctly named single effects with their size in its 95 % interval, see `coverage`.
        calibration: Of the first cause, over all logs in which one was claimed, nested effects counted as right.
        detection: A gap was seen, against the expected gain, over all single effects.
        naming: The right name came first (nested ones too), against the expected gain, over all single effects.
        closed: Median closed fraction of visible single effects.
        closed_oracle: Median of the closed fraction over that of the true structure refitted.
        closed_rival: Median closed fraction of the best impostor, the best explanation that was not chosen.
        margin: Median closed fraction less that of the best impostor.
        closed_third: Median closed fraction of the patches on third logs, which neither fit nor check has seen.
        third_95: Visible single effects whose patch closes 95 % of the gap or more there.
        seconds: Median time of a diagnosis [s].
    """

    cases: int
    top_1: Share
    top_1_nested: Share
    top_3: Share
    in_group: Share
    group_size: float
    location: Share
    detected: Share
    false_alarms: Share
    unknown_found: Share
    unknown_seen: Share
    known_unknown: Share
    pairs: Share
    pairs_nested: Share
    refused: Share
    covered: Share
    calibration: Calibration | None
    detection: DetectionCurve
    naming: DetectionCurve
    closed: float
    closed_oracle: float
    closed_rival: float
    margin: float
    closed_third: float
    third_95: Share
    seconds: float


def score(answers: Sequence[Answer]) -> Score:
    """Count.

    Args:
        answers: The cases.

    Returns:
        The figures.
    """
    of = {kind: [one for one in answers if one.truth.kind == kind] for kind in ("single", "null", "unknown", "pair")}
    seen = [one for one in of["single"] if one.visible]
    pairs = [one for one in of["pair"] if one.visible]
    claimed = [one for one in answers if one.first is not None]
    named = [one for one in seen if one.named(1, nested=True)]
    stated = np.array([one.first.probability for one in claimed if one.first is not None])
    right = np.array([one.named(1, nested=True) for one in claimed], dtype=float)
    return Score(
        cases=len(answers),
        top_1=share(one.named(1) for one in seen),
        top_1_nested=share(one.named(1, nested=True) for one in seen),
        top_3=share(one.named(3) for one in seen),
        in_group=share(one.in_group for one in seen),
        group_size=_mean([one.group_size for one in seen if one.alarm]),
        location=share(one.named(1, nested=True, placed=True) for one in named),
        detected=share(one.alarm for one in seen),
        false_alarms=share(one.alarm for one in of["null"]),
        unknown_found=share(one.unknown for one in of["unknown"]),
        unknown_seen=share(one.alarm for one in of["unknown"]),
        known_unknown=share(one.unknown for one in (*seen, *pairs)),
        pairs=share(one.both() for one in pairs),
        pairs_nested=share(one.both(nested=True) for one in pairs),
        refused=share(one.diagnosis is None for one in answers),
        covered=share(one.covered for one in fitted_sizes(answers)),
        calibration=calibration(stated, right),
        detection=_curve(of["single"], lambda one: one.alarm),
        naming=_curve(of["single"], lambda one: one.named(1, nested=True)),
        closed=median([one.closed for one in seen]),
        closed_oracle=median([one.closed / one.oracle for one in seen if one.closed is not None and one.oracle]),
        closed_rival=median([one.closed_rival for one in seen]),
        margin=median([_margin(one) for one in seen]),
        closed_third=median([one.closed_third for one in seen]),
        third_95=share((one.closed_third or 0.0) >= MOST for one in seen if _tried(one)),
        seconds=median([one.seconds for one in answers]),
    )


def _curve(answers: Sequence[Answer], found: Callable[[Answer], bool]) -> DetectionCurve:
    return detection_curve(
        np.array([one.truth.gain for one in answers]), np.array([found(one) for one in answers], dtype=float)
    )


def _tried(one: Answer) -> bool:
    """Whether there was a patch for the third log, and a gap to be closed there."""
    return one.third is not None and (one.closed_third is not None or bool(one.third.failure))


def _margin(one: Answer) -> float | None:
    return None if one.closed is None or one.closed_rival is None else one.closed - one.closed_rival


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def confusion(answers: Sequence[Answer]) -> dict[str, Counter[str]]:
    """Count the reported answers of visible single effects, logs without deviation and causes outside the library.

    Args:
        answers: The cases.

    Returns:
        Numbers by truth and by reported answer.
    """
    table: dict[str, Counter[str]] = {}
    for one in answers:
        if one.truth.kind in ("pair", "crowd") or (one.truth.kind == "single" and not one.visible):
            continue
        name = one.truth.deviations[0].effect if one.truth.deviations else "nothing"
        table.setdefault(name, Counter())[one.reported] += 1
    return dict(sorted(table.items()))


GROUPINGS = ("robot", "nuisance", "size", "tool", "motion", "sample_time")
"""Keys of a truth by which scores are grouped."""


def scores_by(answers: Sequence[Answer], key: str) -> dict[str, Score]:
    """Count apart by a key of the truth.

    Args:
        answers: The cases.
        key: One of `GROUPINGS`.

    Returns:
        Scores by value of the key.
    """
    values = sorted({str(getattr(one.truth, key)) for one in answers})
    return {value: score([one for one in answers if str(getattr(one.truth, key)) == value]) for value in values}


def record(answers: Sequence[Answer]) -> dict[str, Any]:
    """Convert all figures to nested dicts, lists and numbers for JSON.

    Args:
        answers: The cases.
    """
    return {
        "visible_from": VISIBLE,
        "all": asdict(score(answers)),
        **{key: {value: asdict(one) for value, one in scores_by(answers, key).items()} for key in GROUPINGS},
        "effects": {name: asdict(one) for name, one in _by_effect(answers).items()},
        "crowds": {name: asdict(crowd_score(some)) for name, some in crowd_groups(answers).items() if some},
        "confusion": {truth: dict(counts) for truth, counts in confusion(answers).items()},
    }


def _by_effect(answers: Sequence[Answer]) -> dict[str, Score]:
    singles = [one for one in answers if one.truth.kind == "single"]
    names = sorted({one.truth.deviations[0].effect for one in singles})
    return {name: score([one for one in singles if one.truth.deviations[0].effect == name]) for name in names}
