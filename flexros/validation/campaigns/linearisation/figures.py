"""Medians, intervals and comparisons of the runs of the study."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import binom

from flexros.json_text import json_text
from flexros.validation.campaigns.linearisation.laws import LAWS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.validation.campaigns.linearisation.laws import Law
    from flexros.validation.campaigns.linearisation.settings import LinearisationSettings

_NUMBERS = re.compile(r"\[\s*((?:[-+.\deE]+|null)(?:,\s*(?:[-+.\deE]+|null))*)\s*\]")

LEVEL = 0.95
"""Confidence of the intervals."""
COLUMNS = ("median", "low", "high", "lost", "runs")
"""Meaning of the numbers of a figure in the record."""


@dataclass(frozen=True)
class Figure:
    """Median of a figure over the runs of a condition; a lost run counts as infinite.

    Attributes:
        median: Median; infinite if half of the runs are lost.
        low: Lower end of the 95 % interval of the median, from order statistics.
        high: Upper end.
        lost: Number of runs that were lost.
        runs: Number of runs.
    """

    median: float
    low: float
    high: float
    lost: int
    runs: int

    def as_row(self) -> list[float | int | None]:
        """Return the figure for JSON in the order of `COLUMNS`; None where infinite."""
        ends = (self.median, self.low, self.high)
        return [*(float(f"{value:.4g}") if np.isfinite(value) else None for value in ends), self.lost, self.runs]


def figure_of(values: Sequence[float | None]) -> Figure:
    """Summarise the runs of a condition.

    Args:
        values: One value per run, None where it was lost.
    """
    ordered = sorted(np.inf if value is None else value for value in values)
    n = len(ordered)
    low = max(int(binom.ppf((1 - LEVEL) / 2, n, 0.5)), 1) - 1
    middle = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    return Figure(middle, ordered[low], ordered[n - 1 - low], sum(value is None for value in values), n)


@dataclass(frozen=True, eq=False)
class Results:
    """All parts of the study.

    Attributes:
        settings: Settings.
        parts: Results of `law_part` by robot, tuning and name of the law.
        robustness: Results of `robustness_part` by robot.
    """

    settings: LinearisationSettings
    parts: Mapping[tuple[str, str, str], Mapping[str, Any]]
    robustness: Mapping[str, Mapping[str, Any]]

    def laws(self, robot: str, tuning: str) -> tuple[Law, ...]:
        """Return the laws that fit a robot, in order."""
        return tuple(
            law
            for law in LAWS
            if law.name in self.settings.laws and "runs" in self.parts.get((robot, tuning, law.name), {})
        )

    def refusals(self, robot: str) -> dict[str, str]:
        """Return why laws do not fit a robot, by law."""
        found = {}
        for (name, _, law), part in self.parts.items():
            if name == robot and "refused" in part:
                found[law] = str(part["refused"])
        return found

    def values(self, robot: str, tuning: str, law: str, condition: str, key: str) -> Sequence[float | None]:
        """Return one figure of all runs of a condition."""
        values: Sequence[float | None] = self.parts[robot, tuning, law]["runs"][condition][key]
        return values

    def figure(self, robot: str, tuning: str, law: str, condition: str, key: str) -> Figure:
        """Return the median of a figure over the runs of a condition."""
        return figure_of(self.values(robot, tuning, law, condition, key))

    def best(self, robot: str, tuning: str, condition: str, key: str, laws: Sequence[str] = ()) -> str:
        """Return the law of the least median among some laws, or all."""
        names = [law.name for law in self.laws(robot, tuning) if not laws or law.name in laws]
        return min(names, key=lambda name: self.figure(robot, tuning, name, condition, key).median)


@dataclass(frozen=True)
class Duel:
    """Comparison of two laws on the same plants and noise.

    Attributes:
        better: Number of runs in which the first law has the smaller error.
        runs: Number of runs.
        ratio: Median of the error of the first over that of the second; a lost run counts as infinite.
        low: Lower end of the 95 % interval of the median ratio.
        high: Upper end.
    """

    better: int
    runs: int
    ratio: float
    low: float
    high: float


def duel(first: Sequence[float | None], second: Sequence[float | None]) -> Duel:
    """Compare two laws run by run.

    Args:
        first: Errors of the first law, None where lost.
        second: Errors of the second law, same length.
    """
    a, b = (np.array([np.inf if value is None else value for value in values]) for values in (first, second))
    ratio = np.where(np.isinf(a), np.inf, a / b)
    found = figure_of([float(value) for value in ratio])
    return Duel(int(np.sum(a < b)), len(a), found.median, found.low, found.high)


def record_of(results: Results) -> dict[str, Any]:
    """Return all figures for JSON: by robot, tuning and law the numbers of the law, then rows by condition."""
    record: dict[str, Any] = {}
    for (robot, tuning, law), part in results.parts.items():
        entry = record.setdefault(robot, {}).setdefault(tuning, {})
        if "refused" in part:
            entry[law] = {"refused": part["refused"]}
            continue
        runs = {
            condition: {key: figure_of(values).as_row() for key, values in figures.items()}
            for condition, figures in part["runs"].items()
        }
        entry[law] = {"tuning": part["tuning"], "conditions": runs}
    return record


def record_text(record: Mapping[str, Any]) -> str:
    """Return the record as JSON text, each list of numbers on one line."""

    def one_line(found: re.Match[str]) -> str:
        return f"[{', '.join(part.strip() for part in found[1].split(','))}]"

    return _NUMBERS.sub(one_line, json_text(record))
