"""Write crowds_of_all_seeds.md: python docs/results/programs/crowds_page.py.

It adds the blind crowds of all seeds, which `flexros campaign crowds` left in docs/results/data.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from flexros.validation.campaigns.coverage.figures import wilson

RESULTS = Path(__file__).parents[1]
SEEDS = ("crowds", *(f"crowds_{nth}_seed" for nth in ("second", "third", "fourth", "fifth")))
"""Names of the pages, in the order of their runs."""
GROUPS = ("nominal exact", "nominal 3 % off", "one cause outside the library")
ROWS = (
    ("recall", "effects named at their location (recall)", ("95 %", "88 %", "")),
    ("precision", "named causes that are hidden there (precision)", ("97 %", "95 %", "")),
    ("whole", "whole crowd named and nothing else", ("", "", "")),
    ("covered", "sizes in their 95 % intervals", ("90 %", "", "")),
    ("over_claims", "`explained` although more than the floor is left", ("at most 1 %",) * 3),
    ("over_truth", "the same, and more than twice what the true effects leave", ("", "", "")),
    ("third_97", "patch closes 97 % of what the true effects close of a third log", ("", "", "")),
)
MISSED = """
## What was missed

Recall and precision are below their goals on exact models and on those that are 3 % off; what is missing is named seed
by seed in [the blind check](../explanation/blind_check.md). Most of it is worth less than 3,000 nats beside effects of
a hundred thousand, whose laws have another form in the simulator (a hump of friction, a rounded saturation), or does in
the log what another effect does: a delay and a lag of 50 us, a base mode at 135 Hz and a softer spring, a mode at the
tool and a load. On `six_axis` with a nominal model 3 % off one case of the fourth seed had not ended after 25 minutes
and one of the fifth after 17; they are in no figure, and the goal of speed is missed there.

Five answers are `explained` although more than two floors are left on the third log. In two of them all is named and
nothing else; the rest, 2.3 floors of 4,800 and 375,000, is the other form of the laws. Bristles stand for Coulomb
friction of 677 nats (`elbow`, 2.1 floors of 190,000), five effects of 320 to 7,900 nats are missing on a rigid arm of
six axes 3 % off (3.8 floors of 610,000), and a backlash of 255 nats on `elbow` 3 % off (23 floors of 142,000).

Sizes are compared where the nominal model is exact: on one that is 3 % off the size of an error of a number is relative
to that number. Patches are compared with the true effects without a refit, so that a patch may do better than these.
"""


def shown(hits: int, number: int) -> str:
    """Write a share with its interval and the numbers it is of."""
    if not number:
        return ""
    found = wilson(hits, number)
    share, low, high = (100 * one for one in (found.value, found.low, found.high))
    return f"{share:.1f} % ({low:.1f} to {high:.1f}), {hits} of {number}"


def _counted(share: dict[str, Any]) -> str:
    return f"{share['hits']} of {share['cases']}"


def added(found: dict[str, dict[str, Any]], group: str, row: str) -> tuple[int, int]:
    """Add hits and trials of all seeds."""
    shares = [scores[group][row] for scores in found.values() if group in scores]
    shares = [one for one in shares if one]
    return sum(one["hits"] for one in shares), sum(one["cases"] for one in shares)


def page(found: dict[str, dict[str, Any]], commits: dict[str, str]) -> str:
    """Write the page.

    Args:
        found: Scores by name of the seed.
        commits: The commits that ran them.
    """
    cases = sum(scores["all"]["cases"] for scores in found.values())
    lines = [
        "# Blind crowds of all seeds",
        "",
        f"Written by `python docs/results/programs/crowds_page.py`: {cases} crowds of 3 to 12 hidden effects, from",
        f"{len(found)} seeds that were not used in development, each diagnosed once by the code of its day. Shares",
        "have 95 % intervals (Wilson), as if the effects of a crowd were independent.",
        "",
        f"| | {' | '.join(GROUPS)} |",
        "|---|---|---|---|",
    ]
    for row, text, goals in ROWS:
        cells = [shown(*added(found, group, row)) for group in GROUPS]
        told = [f"{one}; goal {goal}" if one and goal else one for one, goal in zip(cells, goals, strict=True)]
        lines.append(f"| {text} | {' | '.join(told)} |")
    lines += ["", "| seed | commit | exact: recall / precision | 3 % off: recall / precision |", "|---|---|---|---|"]
    for name, scores in found.items():
        both = [" / ".join(_counted(scores[group][row]) for row in ("recall", "precision")) for group in GROUPS[:2]]
        lines.append(f"| [{name.replace('_', ' ')}]({name}.md) | {commits[name]} | {both[0]} | {both[1]} |")
    return "\n".join(lines) + "\n" + MISSED


def main() -> None:
    """Write the page."""
    assert __doc__ is not None
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    files = [RESULTS / "data" / f"{name}.json" for name in SEEDS]
    read = {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files}
    text = page(
        {name: one["scores"] for name, one in read.items()},
        {name: one["versions"]["commit"] for name, one in read.items()},
    )
    (RESULTS / "crowds_of_all_seeds.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
