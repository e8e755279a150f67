"""Figures in sentences: numbers with their deviation, shares, gaps, intervals, p-values, frequency bands."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.schema import GapNumbers

DIVERGED = 1e24
"""Size of a gap from which predictions ran away within the horizon [1] (chosen)."""
MOST_SHARE = 10.0
"""Share that is written as a number at most [1] (chosen)."""
_CERTAIN = 1.0 - 1e-12
"""Share from which it is all of it but for round-off [1]."""
_NEARLY_ALL, _ALL = 0.95, 0.9995
"""Closed shares between these are stated with a decimal (chosen)."""
FLOORS_LEFT = 2.0
"""Floors above which something is left of a gap [1]; `explained` is judged alike (chosen)."""
_MOST_PLACES, _LARGE = 6, 1e6
"""Values with more decimals, or as large as this, are written with an exponent (chosen)."""
_SMALL = 0.1
"""Values below this share of their unit take the next smaller prefix (chosen)."""
SCALED = ("rad", "m", "s", "Nm", "N")
"""Units that take a prefix where the value is small."""
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"))


def with_std(value: float, std: float, unit: str = "") -> str:
    """Write a number to two digits of its standard deviation, e.g. "5.44 kg m2 (±0.43)".

    Args:
        value: The number.
        std: Its standard deviation; the number is written to four digits where it is not known.
        unit: Its unit; none is written by default.
    """
    gap = " " if unit else ""
    if not (math.isfinite(std) and std > 0):
        return f"{number(value, 4)}{gap}{unit}"
    places = 1 - math.floor(math.log10(std))
    if not 0 <= places <= _MOST_PLACES or abs(value) >= _LARGE:
        return f"{number(value, 4)}{gap}{unit} (±{number(std, 2)})"
    return f"{round(value, places) + 0.0:.{places}f}{gap}{unit} (±{std:.{places}f})"  # + 0.0: no minus zero


def scaled(size: float, unit: str) -> tuple[float, str]:
    """Return a scale for numbers of some size, and their unit with its prefix."""
    if unit not in SCALED:
        return 1.0, unit
    scale, prefix = next(((scale, prefix) for scale, prefix in _PREFIXES if size >= _SMALL * scale), _PREFIXES[-1])
    return scale, prefix + unit


def share_words(share: float) -> str:
    """Write a share in whole per cent, as "under 1 %" or "over 99 %" where it is nearly none or all.

    Args:
        share: The share [1]; above a factor of ten, as of a fit that strays, it is "over 1000 %".
    """
    if share <= 0:
        return "0 %"
    if not share <= MOST_SHARE:
        return f"over {100 * MOST_SHARE:.0f} %"
    if share < 0.01:
        return "under 1 %"
    return f"{100 * share:.0f} %" if share <= 0.99 or share >= _CERTAIN else "over 99 %"


def signed_share_words(share: float) -> str:
    """Write a change of a share in whole per cent with its sign, e.g. "+12 %", "-3 %", "0 %".

    Args:
        share: The change [1]; beyond a factor of ten it is "over +1000 %".
    """
    text = f"{100 * min(max(share, -MOST_SHARE), MOST_SHARE):+.0f} %"
    if abs(share) > MOST_SHARE:
        text = f"over {text}"
    return "0 %" if text[1:] == "0 %" else text.replace("-", "\u2212")


def closed_words(share: float) -> str:
    """Write a share of the gap that is closed, with a decimal where it is nearly all, e.g. "83 %", "99.7 %".

    Args:
        share: The share [1]; below zero where the repair makes it worse; values above 1, by chance, are written as 1.
    """
    share = min(share, 1.0)
    return f"{100 * share:.1f} %" if _NEARLY_ALL <= share < _ALL else whole_percent(share)


def gap_closed_words(gap: GapNumbers) -> str:
    """Write the share of a gap that is closed, as "over 99.9 %" where it is nearly all but floors are left.

    Args:
        gap: The gap, with its closed share.
    """
    share = math.nan if gap.closed_fraction is None else gap.closed_fraction
    left = gap.after is not None and gap.after > FLOORS_LEFT * gap.noise_floor
    return "over 99.9 %" if left and share >= _ALL else closed_words(share)


def whole_percent(share: float) -> str:
    """Write a share in whole per cent, e.g. "12 %", "−3 %".

    Args:
        share: The share [1].
    """
    return f"{round(100 * share)} %".replace("-", "\u2212")


def gap_words(size: float, digits: int = 3) -> str:
    """Write the size of a gap; one so large that predictions ran away within the horizon says nothing but that.

    Args:
        size: Mean squared prediction error over its floor [1].
        digits: Significant digits.
    """
    return "divergence" if size > DIVERGED else number(size, digits)


def floors_words(gap: GapNumbers) -> str:
    """Write the floor of a gap, and with torques off by their tolerance, e.g. "floor 1, 24.9 with tolerance"."""
    floor = f"floor {number(gap.noise_floor, 4)}"
    return floor if gap.tolerance_floor is None else f"{floor}, {gap_words(gap.tolerance_floor)} with tolerance"


def shows(gap: GapNumbers) -> bool:
    """Whether a gap exceeds its floor, so that a closed share is meaningful."""
    return gap.before > gap.noise_floor


def interval_words(interval: tuple[float, float] | None) -> str:
    """Write the interval of a closed share in brackets, with a leading blank; empty where its ends read the same.

    Args:
        interval: Its ends [1]; None for none.
    """
    return _between(interval, closed_words)


def share_interval_words(interval: tuple[float, float] | None) -> str:
    """Write the interval of a share of the gap in brackets, with a leading blank; empty where its ends read the same.

    Args:
        interval: Its ends [1], not written out beyond a factor of ten, as of a fit that strays; None for none.
    """
    return _between(interval, lambda end: whole_percent(end) if abs(end) <= MOST_SHARE else signed_share_words(end))


def _between(interval: tuple[float, float] | None, words: Callable[[float], str]) -> str:
    if interval is None:
        return ""
    low, high = map(words, interval)
    return "" if low == high else f" ({low} to {high})"


def p_value_words(p_value: float, realisations: int = 0) -> str:
    """Write a p-value, e.g. "p = 0.03", "p < 0.001", "p ≤ 0.005" where simulated logs can tell no less.

    Args:
        p_value: Probability of such an excess by chance [1].
        realisations: Simulated logs without a gap that it was counted in; 0 where not known.
    """
    if realisations and 0.5 < p_value * (realisations + 1) < 1.5:
        return f"p ≤ {number(p_value, 1)}"
    return "p < 0.001" if p_value < 1e-3 else f"p = {number(p_value, 2)}"


def band_words(band: tuple[float, float], highest: float = 1e9) -> str:
    """Write a frequency band, e.g. "8 to 20 Hz", "below 2 Hz", "all frequencies".

    Args:
        band: Its ends [Hz].
        highest: Nyquist frequency of the log [Hz], which is not stated as a limit.
    """
    low, high = band
    if low <= 0:
        return "all frequencies" if high >= 0.999 * highest else f"below {number(high, 3)} Hz"
    return f"above {number(low, 3)} Hz" if high >= 0.999 * highest else f"{number(low, 3)} to {number(high, 3)} Hz"
