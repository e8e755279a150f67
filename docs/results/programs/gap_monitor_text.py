"""Text of gap_monitor.md, from the results of gap_monitor_page.py."""

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

Written by `python docs/results/programs/gap_monitor_page.py page`, from what `... nominal`, `... detection` and
`... accepted` measured. Motions and noise use seeds from 5000 on, which were not used in development.
Motions are those of the diagnosis experiment, a different sequence for each seed. All thresholds follow from the noise,
without a calibration. The load of the monitor next to a running loop is reported in
`docs/results/gap_monitor_load.md`.
"""
FALSE = """
## False alarms

Robots without a gap to their models. `Beyond` counts mean squares above the thresholds of a rate of false alarms, with
the number expected at that rate for these runs (the probability is at most 1 % per mean square) and the 95 % interval
(Poisson) of the count. The default, one alarm in 1000 h, is not counted but extrapolated by the theory that the larger
rates confirm; its column gives the upper bound from counting. Hardening gears (`four_mass`) get the thresholds of
their worst load.

| robot | watched | alarms at 0.001/h | beyond 1/h | beyond 10/h | beyond 100/h | mean squares of noise |
|---|---|---|---|---|---|---|
"""
ONSETS = """
## Effects that begin during a run

The robot equals its model for {onset:g} s. Then the effect begins at once at full size, and the motion continues for
about 20 s. `Detected` counts runs with an alarm after the onset, `before` those with an earlier alarm. Delay: from the
onset to the end of the window that raised the alarm, median and longest; an effect does not show before the motion
excites it. Joint and side (motor, gear, arm, tool) are those that the monitor names last; the right joint of a payload
is the tool.

| robot | effect | size | detected | before | delay, median | longest | right joint | right side |
|---|---|---|---|---|---|---|---|---|
"""
ACCEPTED = """
## Robots with an accepted gap

The robot has effects that its model does not contain. One log of 120 s is accepted (`--calibrate`). Six further logs
of 40 s with other motions are monitored with those thresholds, then some with an additional effect from their start.
Gap: disturbance torque over noise, median. `Detected`: runs with an alarm, and with the right joint.

| robot | accepted | accepted gap | alarms in six logs | additional effect, detected |
|---|---|---|---|---|
"""
SIDES = {
    "coulomb_friction": ("motor",),
    "viscous_friction": ("motor",),
    "backlash": ("gear",),
    "stiffness_error": ("gear",),
    "payload_error": ("tool", "arm"),
}
"""Right sides by effect; a robot of one motor without a tool in its dynamics has its payload on the arm side."""


def page_text(work: Path, rates: Sequence[float], onset: float) -> str:
    """Write the page from the files of a folder.

    Args:
        work: The folder.
        rates: Rates of false alarms that were counted [1/h].
        onset: Onset of the effects [s].
    """
    parts = [HEAD, FALSE, *_false_rows(_rows(work / "nominal.jsonl"), rates)]
    if rows := _rows(work / "detection.jsonl"):
        parts += [ONSETS.format(onset=onset), *_onset_rows(rows)]
    if rows := _rows(work / "accepted.jsonl"):
        parts += [ACCEPTED, *_accepted_rows(rows)]
    return "".join(parts)


def _rows(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def interval(count: int) -> tuple[float, float]:
    """Return the 95 % interval of a Poisson mean for an observed count."""
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
            expected = sum(_expected(row, rate) for row in own)
            cells.append(f"{int(count)} of {expected:.1f} ({low:.1f} to {high:.1f})")
        mean = "-"
        if robot != "all":
            means = np.mean([row["mean"] for row in own], axis=0)
            half = len(means) // 2
            mean = f"innovation {_range(means[:half])}, torque {_range(means[half:])}"
        upper = f"{alarms}, below {interval(alarms)[1] / hours:.2g}/h"
        lines.append(f"| {robot} | {hours:.2f} h | {upper} | {' | '.join(cells)} | {mean} |\n")
    return lines


def _expected(row: dict[str, Any], rate: float) -> float:
    """Return the expected number of mean squares above the thresholds of a rate, in the whole windows of the runs."""
    windows, signals = round(row["watched_hours"] * 36000 / row["runs"]), len(row["mean"])
    chances = chances_of(signals, rate)
    beyond = sum(windows // length * chance for length, chance in zip(LENGTHS, chances))
    return float(row["runs"] * signals * beyond)


def _range(values: Any) -> str:
    return f"{values[0]:.3f}" if len(values) == 1 else f"{min(values):.3f} to {max(values):.3f}"


def _onset_rows(rows: list[dict[str, Any]]) -> list[str]:
    groups: dict[tuple[str, str, float], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["robot"], row["effect"], row["size"]), []).append(row)
    lines = []
    for (robot, effect, size), own in sorted(groups.items()):
        detected = [row for row in own if row["delay"] is not None]
        delays = [row["delay"] for row in detected]
        name, location = effect.split("@")
        joint = sum(_right_joint(row, location) for row in detected)
        side = sum(row["kind"] in SIDES[name] for row in detected)
        wait = f"{np.median(delays):.1f} s | {max(delays):.1f} s" if delays else "- | -"
        before = sum(row["before"] for row in own)
        lines.append(
            f"| {robot} | `{effect}` | {size:g} | {len(detected)} of {len(own)} | {before} | "
            f"{wait} | {joint} of {len(detected)} | {side} of {len(detected)} |\n"
        )
    detected = [row for row in rows if row["delay"] is not None]
    joints = sum(_right_joint(row, row["effect"].split("@")[1]) for row in detected)
    lines.append(f"\nThe right joint was named in {joints} of {len(detected)} alarms.\n")
    return lines


def _right_joint(row: dict[str, Any], location: str) -> bool:
    """Return whether the named joint is that of the effect; a robot of one motor has a single joint."""
    return bool(row["joint"] == location or (row["joint"] != "" and row["robot"].startswith("four_mass")))


def _accepted_rows(rows: list[dict[str, Any]]) -> list[str]:
    lines = []
    for row in rows:
        gaps = ", ".join(f"{name} {value:.0f}" for name, value in row["accepted"].items())
        detected = "; ".join(f"{size}: {a} of {n}, joint {b}" for size, (a, b, n) in row["told"].items())
        lines.append(
            f"| {row['robot']} | {', '.join(f'`{effect}`' for effect in row['known'])} | {gaps} | {row['false']} | "
            f"`{row['effect']}` {detected} |\n"
        )
    return lines
