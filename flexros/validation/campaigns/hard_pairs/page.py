"""Page of results of the hard pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.validation.campaigns.markdown import version_line

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.validation.campaigns.hard_pairs.settings import HardPairsSettings


NOTES = {
    "backlash, hysteresis": "Backlash reduces the stiffness near zero torque, hysteresis increases it after every "
    "reversal. Neither explains the other, so sizes just above the detection limit are named at once. Fits of these "
    "two alone with springs, dampers and inertias free within 20, 50 and 10 % give the same result.",
}
"""Further notes on a pair (development seeds)."""


def pairs_page(
    by_pair: Mapping[str, Sequence[Mapping[str, Any]]], settings: HardPairsSettings, used: Mapping[str, str]
) -> str:
    """Write the page.

    Args:
        by_pair: What `pair_part` gave of each truth, by pair.
        settings: Settings of the campaign.
        used: Versions by package.

    Returns:
        Markdown.
    """
    lines = [
        "# Effects that a log cannot separate, and the experiment that does",
        "",
        f"Written by `flexros campaign hard_pairs`. The robot is {settings.robot}; one effect is hidden in it, of a "
        "size near the detection limit of the first log, where a pair is hardest to separate. That log contains "
        f"{settings.duration:g} s of slow moves: two thirds are fitted, the last third is held out. Where the answer "
        "is ambiguous, the experiment that the diagnosis proposes is run on the same robot, and its log is diagnosed "
        "without the first one.",
    ]
    for pair, parts in by_pair.items():
        lines += ["", f"## {pair.replace(', ', ' and ')}", "", pair_sentence(pair, parts), ""]
        lines += ["| hidden | first log | causes | group | next experiment | then | causes |", "|---" * 7 + "|"]
        lines += [_row(part) for part in parts]
        lines += ["", NOTES[pair]] if pair in NOTES else []
    lines += ["", f"{version_line(used)}."]
    return "\n".join(lines) + "\n"


def pairs_summary(by_pair: Mapping[str, Sequence[Mapping[str, Any]]]) -> tuple[str, ...]:
    """Return the result of each pair in a sentence.

    Args:
        by_pair: What `pair_part` gave of each truth, by pair.
    """
    return tuple(f"{pair}: {pair_sentence(pair, parts)}" for pair, parts in by_pair.items())


def pair_sentence(pair: str, parts: Sequence[Mapping[str, Any]]) -> str:
    """Count groups and separations of a pair.

    Args:
        pair: Names of both effects, with a comma between them.
        parts: What `pair_part` gave of its truths.
    """
    detected = [part for part in parts if part["first"]["verdict"] != "no_gap"]
    grouped = [part for part in detected if is_grouped(pair, part)]
    separated = [part for part in grouped if is_separated(part)]
    named = [part for part in detected if part["first"]["verdict"] == "explained" and _right(part, "first")]
    text = f"Of {len(parts)} first logs {len(detected)} showed a gap; {len(grouped)} left both effects in a group"
    text += f", and the proposed experiment separated {len(separated)} of these." if grouped else "."
    return f"{text} In {len(named)} the first log alone named the right effect." if named else text


def is_grouped(pair: str, part: Mapping[str, Any]) -> bool:
    """Whether the first log left both effects of a pair in one ambiguity group.

    Args:
        pair: Names of both effects, with a comma between them.
        part: What `pair_part` gave.
    """
    return any(set(pair.split(", ")) <= set(group) for group in part["first"]["groups"])


def is_separated(part: Mapping[str, Any]) -> bool:
    """Whether the second log named the hidden effect, without rival.

    Args:
        part: What `pair_part` gave.
    """
    second = part["second"]
    return second is not None and second["verdict"] == "explained" and _right(part, "second")


def _right(part: Mapping[str, Any], which: str) -> bool:
    causes = part[which]["causes"]
    return bool(causes) and causes[0][0] == part["truth"].partition("@")[0]


def _row(part: Mapping[str, Any]) -> str:
    first, second = part["first"], part["second"]
    following = "" if first["experiment"] is None else f"{first['experiment']} ({first['expected_gain']:.3g} nats)"
    cells = [
        f"`{part['truth']}`",
        first["verdict"],
        _causes(first),
        "; ".join(", ".join(group) for group in first["groups"]),
        following,
        "" if second is None else second["verdict"],
        "" if second is None else _causes(second),
    ]
    return f"| {' | '.join(cells)} |"


def _causes(answer: Mapping[str, Any]) -> str:
    return ", ".join(f"{effect} {100 * probability:.0f} %" for effect, _, probability in answer["causes"][:3])
