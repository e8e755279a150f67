"""The page of results: intervals that cover the truth, errors of springs, robot time, for every way to estimate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.validation.campaigns.coverage.estimates import DEFAULT
from flexros.validation.campaigns.markdown import table, version_line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.campaigns.coverage.figures import ParameterCoverage, Share, WayCoverage
    from flexros.validation.campaigns.coverage.settings import CoverageSettings

LOWEST, HIGHEST = 0.91, 0.98
"""Goal of the share of covering intervals."""

GEAR_SPRINGS, ARM_SPRINGS = 0.05, 0.20
"""Goal of the largest relative errors of springs."""

NOT_DETERMINED = 2
"""Goal of the most parameters that are judged not determined."""

ROBOT_TIME = 1800.0
"""Goal of the time of one experiment [s]."""


def coverage_summary(ways: Sequence[WayCoverage], duration: float) -> tuple[str, ...]:
    """Return in sentences how far the default way reaches each goal.

    Args:
        ways: Figures of every way.
        duration: Robot time of one experiment [s].
    """
    way = next(one for one in ways if one.name == DEFAULT)
    shares = [one.covered.value for one in way.parameters]
    gear, arm, undetermined = way.largest_spring_error(True), way.largest_spring_error(False), way.most_not_determined
    return (
        f"95 % intervals of {way.name} cover the truth in {_share(way.covered)} of {way.repetitions} repetitions (goal "
        f"{100 * LOWEST:g} to {100 * HIGHEST:g} %: {_met(LOWEST <= way.covered.value <= HIGHEST)}); single parameters "
        f"in {_percent(min(shares))} to {_percent(max(shares))}, {_inside(shares)} of {len(shares)} within the goal.",
        f"Largest error in any repetition: {_percent(gear)} of a gear spring (goal {_percent(GEAR_SPRINGS)}: "
        f"{_met(gear <= GEAR_SPRINGS)}), {_percent(arm)} of an arm spring (goal {_percent(ARM_SPRINGS)}: "
        f"{_met(arm <= ARM_SPRINGS)}); at most {undetermined} parameters were judged not determined (goal "
        f"{NOT_DETERMINED}: {_met(undetermined <= NOT_DETERMINED)}).",
        f"Robot time of one experiment: {duration / 60:.1f} min (goal {ROBOT_TIME / 60:g}: "
        f"{_met(duration <= ROBOT_TIME)}).",
    )


def coverage_page(
    ways: Sequence[WayCoverage], settings: CoverageSettings, duration: float, described: dict[str, Any]
) -> str:
    """Write the page.

    Args:
        ways: Figures of every way.
        settings: What was repeated.
        duration: Robot time of one experiment [s].
        described: What the page says of versions, by name.

    Returns:
        Markdown.
    """
    default = next(one for one in ways if one.name == DEFAULT)
    parts = [
        ["# Coverage of the confidence intervals of an identification"],
        ["Written by `flexros campaign coverage` (`make campaign`)."],
        _how(settings, duration),
        ["## Goals", "", *(f"- {sentence}" for sentence in coverage_summary(ways, duration))],
        ["## Estimators and weights", "", *table(_WAYS, (_way_row(way) for way in ways))],
        *_remarks(ways),
        [f"## Parameters, {DEFAULT}", "", *table(_PARAMETERS, (_parameter_row(one) for one in default.parameters))],
        [
            "Bias, spread and std are of logarithms: mean and standard deviation of the errors over the repetitions, "
            "and the median of the standard deviations of the intervals. Errors exclude parameters "
            "where they were judged not determined. Intervals of single parameters are Wilson's; that of all "
            "parameters comes from the differences between sets of phases."
        ],
        [version_line(described)],
    ]
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def _how(settings: CoverageSettings, duration: float) -> list[str]:
    return [
        f"The experiment of scenario `{settings.scenario}` is repeated {settings.repetitions} times on a robot that "
        f"equals the nominal one (nonlinear simulation, encoder noise as in its file): {settings.positions} positions "
        f"chosen out of {settings.candidates} by the D-optimal design, {duration / 60:.1f} min of robot time. "
        f"Groups of {settings.lanes * settings.groups_per_phase} repetitions share random phases; every repetition has "
        f"its own noise. Seeds start at {settings.first_seed} and were not used in development. Every fit starts at a "
        f"random point within a factor of {settings.start_factor:g} of the truth, {_starts(settings.starts)}, with "
        "user weights. The fit with the weights named here starts from its result, as in `flexros identify`, whose "
        f"default is {DEFAULT}. NLS starts from the result of LLS."
    ]


def _remarks(ways: Sequence[WayCoverage]) -> list[list[str]]:
    """Return why intervals with optimal weights are too short, where they are."""
    short = [way.name for way in ways if way.name.endswith("optimal") and way.covered.value < LOWEST]
    if not short:
        return []
    return [
        [
            f"Intervals of {' and '.join(short)} are too short: optimal weights use a variance that is averaged "
            "over neighbouring lines. At a few of the lowest lines, which have large weights, distortions that depend "
            "on the phases exceed it. Combined weights limit the weight of a single line."
        ]
    ]


def _starts(number: int) -> str:
    return "once" if number == 1 else f"{number} times, of which the lowest cost counts"


_WAYS = (
    "way", "covering [%]", "single parameters [%]", "within 91 to 98 %", "gear springs, largest error [%]",
    "arm springs, largest error [%]", "std, median [%]", "not determined, at most", "cost / expected", "not converged",
)  # fmt: skip
_PARAMETERS = (
    "parameter", "covering [%]", "95 % interval [%]", "largest error [%]", "bias [%]", "spread [%]", "std, median [%]",
    "verdicts",
)  # fmt: skip


def _way_row(way: WayCoverage) -> list[str]:
    shares = [one.covered.value for one in way.parameters]
    deviations = sorted(one.deviation for one in way.parameters)
    return [
        way.name,
        _share(way.covered).replace(" %", ""),
        f"{100 * min(shares):.1f} to {100 * max(shares):.1f}",
        f"{_inside(shares)} of {len(shares)}",
        _number(way.largest_spring_error(True)),
        _number(way.largest_spring_error(False)),
        _number(deviations[len(deviations) // 2]),
        str(way.most_not_determined),
        f"{way.reduced_cost:.3g}",
        f"{way.unconverged} of {way.repetitions}",
    ]


def _parameter_row(one: ParameterCoverage) -> list[str]:
    return [
        one.name,
        f"{100 * one.covered.value:.1f}",
        f"{100 * one.covered.low:.1f} to {100 * one.covered.high:.1f}",
        _number(one.largest_error),
        _number(one.bias),
        _number(one.spread),
        _number(one.deviation),
        ", ".join(f"{word.replace('_', ' ')} {count}" for word, count in one.verdicts.items()),
    ]


def _number(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.2g}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _share(share: Share) -> str:
    return f"{100 * share.value:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"


def _inside(shares: Sequence[float]) -> int:
    return sum(LOWEST <= share <= HIGHEST for share in shares)


def _met(met: bool) -> str:
    return "met" if met else "missed"
