"""Text of the page real_robots.md, from the JSON files of its cases."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from real_robots_case import KINDS, NUMBERS
from real_robots_cases import CASES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from real_robots_case import Case, Known

    Found = Mapping[str, Any]

WAYS = {"diagnosis": "diagnosis", "hand": "by hand", "least_squares": "least squares", "mujoco": "MuJoCo"}
"""Ways to a repaired model, with the headings of their columns."""
NEAR = 0.25
"""Relative error up to which a size agrees with what is published (the goal)."""
WITHIN = 1.96
"""Standard deviations to each side of a 95 % interval [1]."""
NAMED, LISTED = 0.5, 0.01
"""Probability from which an effect counts as named, and from which it is listed [1]."""
WORSE = -10.0
"""Share of the gap below which a repair counts as diverging: the number has no meaning there."""
MOST = 12
"""Most rows of a table of effects."""
HEAD = """# Measured robots

Diagnosis of measured logs of real robots: what is known of their gap, what is named, and how much of the gap a repair
closes on logs that were not fitted. Written by

<!-- not run: reads measured data, which are not part of this repository -->
```
pip install "mujoco[sysid]"
python docs/results/programs/measured/fetch_real_robots.py fetched
FLEXROS_REALDATA=<folder with emps/, ...> python docs/results/programs/real_robots.py work --fetched fetched
```

from the JSON files in `docs/results/data/real_robots`, one per case; mappings and robot files of the fetched sets are
in `docs/results/programs/measured`. All settings are the defaults; where a part was written with a robot in view,
its section says so. The last third of the fitted log is held out; where there are further logs, the figures below are
of those, else of that third.

A share of the gap is (E before - E after) / (E before - 1), where E is the mean squared prediction error 0.1 s ahead
over its floor, as `flexros gap` computes it: within its tolerances each model is fitted to the log in question. Below
zero the repair makes the prediction worse. Beside the diagnosis:

- *by hand*: a patch by somebody who knew the answer;
- *least squares*: `flexros identify rigid` with Coulomb and viscous friction and all numbers of the rigid model; where
  it refuses to write a robot, its friction on the nominal numbers;
- *MuJoCo*: damping, dry friction and armature by the toolbox `mujoco.sysid` of MuJoCo 4, from 40 windows of 0.5 s that
  begin in the measured state, in the first two thirds of the fitted log.
"""
SUMMARY = """
## Overview

"Named" counts deviations that are published or follow from least squares: effect and joint, with a probability of at
least 50 %, and with a size within 25 % of the stated range. Shares of the gap are the smallest and the largest of the
logs that were not fitted. Times are of one of two cores beside other work: processor times below tell more. Where
their code had not changed, least squares and MuJoCo are those of an earlier run than that of the diagnosis.

"""


def page(found: Mapping[str, Found]) -> str:
    """Write the page.

    Args:
        found: Content of the JSON file of each case that was run, by name; other cases, and those that were interrupted
            before their diagnosis, are listed as not run.
    """
    done = [(case, found[case.name]) for case in CASES if "diagnosis" in found.get(case.name, {})]
    missing = [case.title for case in CASES if "diagnosis" not in found.get(case.name, {})]
    parts = [HEAD, SUMMARY, *_overview(done), _commits(done)]
    if missing:
        parts.append(f"\nNot run: {', '.join(missing)}.\n")
    for case, content in done:
        parts += _section(case, content)
    return "".join(parts)


def _commits(done: Sequence[tuple[Case, Found]]) -> str:
    """Tell by which commit each case was run."""
    counts = Counter(content.get("versions", {}).get("code", "unknown") for _, content in done)
    cases = ", ".join(f"{code} {number}" for code, number in counts.most_common())
    return f"\nNumber of cases by the commit that ran them, which each JSON file names: {cases}.\n"


def agreement(case: Case, diagnosis: Found) -> list[tuple[Known, float | None, float | None, bool]]:
    """Compare what is known of a gap with what was named.

    Args:
        case: The case.
        diagnosis: Its diagnosis.

    Returns:
        For each known deviation: itself, the value found and its standard deviation, None where it was not named, and
        whether the value is within 25 % of the stated range.
    """
    rows = []
    for known in case.known:
        value, std = _value(known, diagnosis)
        low, high = sorted((known.low * (1 - NEAR), known.high * (1 + NEAR)))
        if known.low < 0:
            low, high = known.low * (1 + NEAR), known.high * (1 - NEAR)
        rows.append((known, value, std, value is not None and low <= value <= high))
    return rows


def within_deviations(known: Known, value: float | None, std: float | None) -> bool:
    """Return whether the range of a known deviation is within a 95 % interval of what was found; arguments as above."""
    if value is None or std is None:
        return False
    return max(known.low - value, value - known.high, 0.0) <= WITHIN * std


def _value(known: Known, diagnosis: Found) -> tuple[float | None, float | None]:
    """Find the value of a known deviation, first among the numbers of the model, then among the causes."""
    for row in diagnosis.get("model_numbers", ()):
        if row["name"] == f"{known.joint}.{NUMBERS.get(known.kind, '-')}" and row.get("determined", True):
            return row["value"], row["std"]
    for cause in diagnosis.get("causes", ()):
        if cause["probability"] < NAMED:
            continue
        for effect, parameter in KINDS[known.kind]:
            if (cause["effect"], cause["location"]) == (effect, known.joint) and parameter in cause["parameters"]:
                entry = cause["parameters"][parameter]
                finding = not entry["at_limit"] and entry.get("determined", True)
                if finding and (parameter != "asymmetry" or entry["value"]):
                    return known.nominal + entry["value"], entry["std"]
    return None, None


def _overview(done: Sequence[tuple[Case, Found]]) -> Iterator[str]:
    yield f"| robot | verdict | named | with its size | {' | '.join(WAYS.values())} | time [s] | memory [GB] |\n"
    yield "|---" * (6 + len(WAYS)) + "|\n"
    for case, content in done:
        diagnosis = content["diagnosis"]
        rows = agreement(case, diagnosis)
        n = len(rows)
        shares = " | ".join(_range(content, way) for way in WAYS)
        memory = diagnosis.get("largest_memory_gb")
        yield (
            f"| [{case.title}](#{_anchor(case.title)}) | {_verdict(diagnosis)} | "
            f"{sum(value is not None for _, value, _, _ in rows)} of {n} | {sum(near for *_, near in rows)} of {n} | "
            f"{shares} | {diagnosis['seconds']:.0f} | {'-' if memory is None else f'{memory:.2f}'} |\n"
        )
    causes = [agreement(case, content["diagnosis"]) for case, content in done if not case.in_hindsight]
    complete = sum(all(value is not None for _, value, _, _ in rows) for rows in causes)
    sized = sum(all(near for *_, near in rows) for rows in causes)
    yield f"\nThe complete cause is named on {complete} of {len(causes)} robots, on {sized} with all its sizes.\n"
    named = [within_deviations(*row[:3]) for rows in causes for row in rows if row[1] is not None]
    yield f"Of the {len(named)} sizes of what is named, {sum(named)} are within {WITHIN} of their standard deviations "
    yield "of the stated range.\n"
    if len(causes) < len(done):
        yield f"{len(done) - len(causes)} more, whose log was chosen with the answers in view, does not count.\n"


def _anchor(title: str) -> str:
    return "".join(letter for letter in title.lower().replace(" ", "-") if letter.isalnum() or letter == "-")


def _closed(content: Found, way: str) -> list[float | None]:
    return [log[way]["closed_fraction"] for log in content.get("logs", {}).values() if way in log]


def _range(content: Found, way: str) -> str:
    closed = [share for share in _closed(content, way) if share is not None]
    if not closed:
        return "-"
    low, high = ("diverges" if share < WORSE else f"{round(100 * share)}" for share in (min(closed), max(closed)))
    return low if high == "diverges" else f"{low} %" if low == high else f"{low} to {high} %"


def _section(case: Case, content: Found) -> Iterator[str]:
    diagnosis = content["diagnosis"]
    yield f"\n## {case.title}\n\n{case.about}\n\nFitted: {_names(case.fitted)}. Known: {case.source}.\n\n"
    command = f"python docs/results/programs/real_robots.py work --fetched fetched --again --cases {case.name}"
    yield f"`{command}` repeats it.\n\n"
    yield f"Verdict {_verdict(diagnosis)} in {_used(diagnosis)}."
    if diagnosis.get("gap", {}).get("closed_fraction") is not None:
        yield f" In the held-out third the patch closes {_share(diagnosis['gap'])} of the gap of {_level(diagnosis)}."
    yield "\n\n| known | joint | stated | found | within 25 % |\n|---|---|---|---|---|\n"
    for known, value, std, near in agreement(case, diagnosis):
        stated = f"{known.low:.4g}" if known.low == known.high else f"{known.low:.4g} to {known.high:.4g}"
        found = "not named" if value is None else _with_std(value, std, known.unit)
        yield f"| {known.kind} | {known.joint} | {stated} {known.unit} | {found} | {'yes' if near else 'no'} |\n"
    yield from _causes(diagnosis)
    yield from _numbers(diagnosis)
    yield from _tolerances(diagnosis)
    yield from _logs(case, content)
    yield from _others(case, content)
    yield from _rest(diagnosis)


def _verdict(diagnosis: Found) -> str:
    return f"`{diagnosis['verdict']}`{' (partial: its time was over)' if diagnosis.get('partial') else ''}"


def _names(files: Iterable[str]) -> str:
    return ", ".join(f"`{file.rpartition('/')[2]}`" for file in files)


def _used(diagnosis: Found) -> str:
    text = f"{diagnosis['seconds']:.0f} s"
    if "cpu_seconds" not in diagnosis:
        return text
    return (
        f"{text} ({diagnosis['cpu_seconds']:.0f} s of processor time, {diagnosis['cores']} cores), "
        f"{diagnosis['largest_memory_gb']:.2f} GB"
    )


def _level(diagnosis: Found) -> str:
    return f"{diagnosis['gap']['before']:.3g} floors"


def _share(gap: Found) -> str:
    """State a share of a gap with its interval."""
    closed, interval = gap.get("closed_fraction"), gap.get("interval")
    if closed is None:
        return "-"
    if closed < WORSE:
        return "diverges"
    text = f"{round(100 * closed, 1) + 0.0:.1f} %"  # never -0.0
    return f"{text} ({100 * interval[0]:.0f} to {100 * interval[1]:.0f})" if interval else text


def _with_std(value: float, std: float | None, unit: str) -> str:
    return f"{value:.4g}{'' if std is None else f' ± {std:.2g}'} {unit}"


def _causes(diagnosis: Found) -> Iterator[str]:
    causes = [cause for cause in diagnosis.get("causes", ()) if cause["probability"] >= LISTED]
    if not causes:
        yield "\nNo effect is named.\n"
        return
    yield "\n| effect | probability | parameters | closed alone |\n|---|---|---|---|\n"
    for cause in causes[:MOST]:
        parameters = ", ".join(
            f"{name} {_with_std(entry['value'], entry['std'], entry['unit'])}{' (at its limit)' * entry['at_limit']}"
            for name, entry in cause["parameters"].items()
        )
        alone = cause["closed_fraction"]
        yield (
            f"| `{cause['effect']}@{cause['location']}` | {100 * cause['probability']:.1f} % | {parameters} | "
            f"{'-' if alone is None else f'{100 * alone:.1f} %'} |\n"
        )
    if len(causes) > MOST:
        yield f"\n{len(causes) - MOST} more are in the JSON file.\n"


def _numbers(diagnosis: Found) -> Iterator[str]:
    rows = diagnosis.get("model_numbers", ())
    if rows:
        listed = (
            f"{row['name']} {row['nominal']:.4g} -> "
            + (_with_std(row["value"], row["std"], row["unit"]) if row.get("determined", True) else "not determined")
            for row in rows
        )
        yield f"\nNumbers of the model that are wrong: {'; '.join(listed)}.\n"


def _tolerances(diagnosis: Found) -> Iterator[str]:
    """Say which names hang on the stated tolerances; nothing where that was not kept, or nothing was guessed."""
    rows = diagnosis.get("tolerance_sensitivity", ())
    changing = [
        f"`{row['effect']}@{row['location']}` "
        f"({', '.join(f'{name} {100 * row[name]:.0f} %' for name in ('halved', 'stated', 'doubled'))})"
        for row in rows
        if row["changes"]
    ]
    if changing:
        yield f"\nHang on the tolerances of the model, with their probabilities: {'; '.join(changing)}.\n"
    elif rows:
        yield "\nNo name changes with halved or doubled tolerances of the model.\n"


def _logs(case: Case, content: Found) -> Iterator[str]:
    logs = content.get("logs", {})
    ways = [way for way in WAYS if any(way in log for log in logs.values())]
    if not ways:
        return
    yield "\nShare of the gap that is closed on logs not fitted, with 95 % intervals:\n\n"
    yield f"| log | gap [floors] | {' | '.join(WAYS[way] for way in ways)} |\n" + "|---" * (2 + len(ways)) + "|\n"
    for name, log in logs.items():
        before = next((gap["before"] for gap in log.values() if "before" in gap), None)
        cells = " | ".join(_share(log.get(way, {})) for way in ways)
        yield f"| {name} | {'-' if before is None else f'{before:.4g}'} | {cells} |\n"


def _others(case: Case, content: Found) -> Iterator[str]:
    if case.by_hand:
        numbers = [f"{name}={value:g}" for name, value in case.numbers_by_hand.items()]
        yield f"\nBy hand: {', '.join(f'`{text}`' for text in (*numbers, *case.by_hand))}.\n"
    squares = content.get("least_squares", {})
    if squares.get("friction"):
        listed = (
            f"{name} {_with_std(row['value'], row['std'], row['unit'])}" for name, row in squares["friction"].items()
        )
        low_pass = f"low-pass of {case.cutoff:g} Hz, " if case.cutoff else ""
        left = f"{squares['torque_error_percent']:.3g} % of the torque left"
        yield f"\nLeast squares ({low_pass}{left}): {'; '.join(listed)}."
        yield f" Refused as a robot: {squares['refused']}.\n" if squares["refused"] else "\n"
    by_mujoco = content.get("mujoco", {})
    if "skipped" in by_mujoco:
        yield f"\nMuJoCo: not applied, since {by_mujoco['skipped']}.\n"
    elif by_mujoco:
        numbers = [f"{name}={value:.4g}" for name, value in by_mujoco["numbers"].items()]
        yield f"\nMuJoCo ({by_mujoco['seconds']:.0f} s): {', '.join((*numbers, *by_mujoco['effects']))}.\n"


def _rest(diagnosis: Found) -> Iterator[str]:
    rest = [
        f"{row['joint']} {row['regime']} {100 * row['share']:.0f} %" for row in diagnosis.get("unexplained", ())[:6]
    ]
    if rest:
        yield f"\nLeft unexplained, as shares of the gap: {'; '.join(rest)}.\n"
    for warning in diagnosis.get("warnings", ()):
        yield f"\n> {warning}\n"
