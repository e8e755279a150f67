"""The text of gap_monitor.md, from what gap_monitor_page.py has gathered."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import chi2

from flexros.monitor.thresholds import LENGTHS, chances_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

HEAD = """# The gap monitor

Written by `python docs/results/gap_monitor_page.py page`, from what `... nominal`, `... detection` and `... accepted`
measured (`docs/results/gap_monitor_page.py` says how; the page tells how far each of them has come). Motions and noise
are of seeds from 5000 on, which were not used in development. Motions are those of the diagnosis experiment, another
sequence for each seed. All thresholds are those of noise, without a calibration. What the monitor costs beside a loop
is in `docs/results/gap_monitor_load.md`.
"""
FALSE = """
## False alarms

Robots that are as their models. `Beyond` counts mean squares beyond the thresholds of a rate of false alarms, with the
number that the rate promises for these runs (chances are at most 1 % per mean square) and the 95 % interval (Poisson)
of what was counted. The default, one alarm in 1000 h, is not counted but extrapolated from the theory that the larger
rates confirm; the column says how far counting goes. Gears that stiffen (`four_mass`) get the thresholds of their
worst load.

| robot | watched | alarms at 0.001/h | beyond 1/h | beyond 10/h | beyond 100/h | mean squares of noise |
|---|---|---|---|---|---|---|
"""
FOUND = """
## Effects that set in

The robot is as its model for {onset:g} s, then the effect is there, at once and in full, and the motion goes on for
some 20 s. `Told` counts runs in which the monitor raised an alarm after the onset; `before` those in which it did so
earlier. Delay: from the onset to the end of the window that raised the alarm, median and longest; an effect does not
show before the motion excites it. Joint and side (motor, gear, arm, tool) are those that the monitor names last; the
right joint of a payload is the tool.

| robot | effect | size | told | before | delay, median | longest | right joint | right side |
|---|---|---|---|---|---|---|---|---|
"""
ACCEPTED = """
## Robots that are not as their models

The robot has effects that its model has not. One log of 120 s is accepted (`--calibrate`), six further ones of 40 s
with other motions are watched with those thresholds, then some with something on top, from their beginning. Gap:
missing torque over noise, median. `Told`: runs with an alarm, and with the right joint.

| robot | accepted | accepted gap | alarms in six logs | on top, told |
|---|---|---|---|---|
"""
SIDES = {
    "coulomb_friction": ("motor",),
    "viscous_friction": ("motor",),
    "backlash": ("gear",),
    "stiffness_error": ("gear",),
    "payload_error": ("tool", "arm"),
}
"""Sides that are right; a robot of one motor and no tool in its dynamics has its payload on the arm side."""


def page_text(work: Path, rates: Sequence[float], onset: float) -> str:
    """Write the page from the files of a folder.

    Args:
        work: The folder.
        rates: Rates of false alarms that were counted [1/h].
        onset: When effects set in [s].
    """
    parts = [HEAD, FALSE, *_false_rows(_rows(work / "nominal.jsonl"), rates)]
    if rows := _rows(work / "detection.jsonl"):
        parts += [FOUND.format(onset=onset), *_found_rows(rows)]
    if rows := _rows(work / "accepted.jsonl"):
        parts += [ACCEPTED, *_accepted_rows(rows)]
    return "".join(parts)


def _rows(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def interval(count: int) -> tuple[float, float]:
    """Give the 95 % interval of a Poisson mean of which a count was seen."""
    return (float(chi2.ppf(0.025, 2 * count) / 2) if count else 0.0, float(chi2.ppf(0.975, 2 * count + 2) / 2))


def _false_rows(rows: list[dict[str, Any]], rates: Sequence[float]) -> list[str]:
    lines = []
    robots = list(dict.fromkeys(row["robot"] for row in rows))
    for robot in [*robots, "all"]:
        own = [row for row in rows if robot in (row["robot"], "all")]
        hours = sum(row["watched_hours"] for row in own)
        alarms = sum(row["alarms"] for row in own)
        counted = np.sum([row["exceeded"] for row in own], axis=0)
        cells = []
        for rate, count in list(zip(rates, counted))[1:]:
            low, high = interval(int(count))
            promised = sum(_promised(row, rate) for row in own)
            cells.append(f"{int(count)} of {promised:.1f} ({low:.1f} to {high:.1f})")
        mean = "-"
        if robot != "all":
            means = np.mean([row["mean"] for row in own], axis=0)
            half = len(means) // 2
            mean = f"sudden {_range(means[:half])}, torque {_range(means[half:])}"
        upper = f"{alarms}, below {interval(alarms)[1] / hours:.2g}/h"
        lines.append(f"| {robot} | {hours:.2f} h | {upper} | {' | '.join(cells)} | {mean} |\n")
    return lines


def _promised(row: dict[str, Any], rate: float) -> float:
    """Give the mean number of mean squares beyond the thresholds of a rate, in the whole windows of the runs."""
    windows, signals = round(row["watched_hours"] * 36000 / row["runs"]), len(row["mean"])
    chances = chances_of(signals, rate)
    beyond = sum(windows // length * chance for length, chance in zip(LENGTHS, chances))
    return float(row["runs"] * signals * beyond)


def _range(values: Any) -> str:
    return f"{values[0]:.3f}" if len(values) == 1 else f"{min(values):.3f} to {max(values):.3f}"


def _found_rows(rows: list[dict[str, Any]]) -> list[str]:
    groups: dict[tuple[str, str, float], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["robot"], row["effect"], row["size"]), []).append(row)
    lines = []
    for (robot, effect, size), own in sorted(groups.items()):
        told = [row for row in own if row["delay"] is not None]
        delays = [row["delay"] for row in told]
        name, place = effect.split("@")
        joint = sum(_right_joint(row, place) for row in told)
        side = sum(row["kind"] in SIDES[name] for row in told)
        wait = f"{np.median(delays):.1f} s | {max(delays):.1f} s" if delays else "- | -"
        lines.append(
            f"| {robot} | `{effect}` | {size:g} | {len(told)} of {len(own)} | {sum(row['before'] for row in own)} | "
            f"{wait} | {joint} of {len(told)} | {side} of {len(told)} |\n"
        )
    told = [row for row in rows if row["delay"] is not None]
    joints = sum(_right_joint(row, row["effect"].split("@")[1]) for row in told)
    lines.append(f"\nThe right joint was named in {joints} of {len(told)} alarms.\n")
    return lines


def _right_joint(row: dict[str, Any], place: str) -> bool:
    """Tell whether the named joint is that of the effect; a robot of one motor has but one."""
    return bool(row["joint"] == place or (row["joint"] != "" and row["robot"].startswith("four_mass")))


def _accepted_rows(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for row in rows:
        gaps = ", ".join(f"{name} {value:.0f}" for name, value in row["accepted"].items())
        told = "; ".join(f"{size}: {a} of {n}, joint {b}" for size, (a, b, n) in row["told"].items())
        lines.append(
            f"| {row['robot']} | {', '.join(f'`{one}`' for one in row['known'])} | {gaps} | {row['false']} | "
            f"`{row['effect']}` {told} |\n"
        )
    return lines
