"""Texts of verdicts and numbers in the report."""

from __future__ import annotations

import math

from flexros.report.number_text import number

VERDICT_WORDS = {"determined": "determined", "weak": "weak", "not_determined": "not determined"}
"""Verdicts as they are read."""

VERDICT_COLOURS = {"determined": "#0072b2", "weak": "#e69f00", "not_determined": "#d55e00"}
"""Colours of verdicts, distinguishable also by the colour-blind."""

_FAR = 1000.0
_MANIFOLD = 10.0
_EVEN = 0.1
"""Ends whose distances from the value differ by at most this share are written as one (chosen)."""


def counted(count: int, what: str) -> str:
    """Write a number of things, e.g. "1 position", "3 positions"."""
    return f"{count} {what}{'s' * (count != 1)}"


def value_text(value: float, significant: int = 5) -> str:
    """Write a value of a parameter without exponent where it has at most nine digits before the point.

    Args:
        value: The value (SI).
        significant: Significant digits.

    Returns:
        E.g. "3075200", "0.0012".
    """
    if 1e6 <= abs(value) < 1e9:
        return str(round(float(f"{value:.{significant - 1}e}")))
    return number(value, significant)


def rounded_text(value: float, low: float, high: float) -> str:
    """Write a value to two digits of its uncertainty, as many as say something.

    Args:
        value: The value, or an end of its interval (SI).
        low: Lower end of the interval (SI).
        high: Upper end (SI).

    Returns:
        E.g. "2499500" for 2499496 with an interval of 2499010 to 2499980, "50.06" for 50.057 with 49.2 to 50.9.
    """
    half = 0.5 * (high - low)
    if not (math.isfinite(half) and 0 < half <= 0.25 * abs(high + low)):
        return value_text(value, 3)
    places = 1 - math.floor(math.log10(half))
    if not 1e-4 <= abs(value) < 1e9:
        return value_text(value, max(places + 1 + math.floor(math.log10(abs(value) or half)), 2))
    return f"{round(value, places):.{max(places, 0)}f}"


def true_text(true: float, low: float, high: float) -> str:
    """Write a true value next to an identified one: whole numbers as such, others as `rounded_text`.

    Args:
        true: The true value (SI).
        low: Lower end of the interval of the identified value (SI).
        high: Upper end (SI).

    Returns:
        E.g. "120000", "61.25".
    """
    return value_text(true, 9) if true == round(true) else rounded_text(true, low, high)


def interval_text(low: float, value: float, high: float) -> str:
    """Write an interval; an end that is farther than a factor of 1000 from the value is unknown and omitted.

    Args:
        low: Lower end (SI).
        value: The value (SI).
        high: Upper end (SI).

    Returns:
        E.g. "2.1 to 2.4", "above 2.1", "unknown".
    """
    lower, upper = known_ends(low, value, high)
    if lower is None:
        return "unknown" if upper is None else f"below {rounded_text(upper, low, high)}"
    if upper is None:
        return f"above {rounded_text(lower, low, high)}"
    return f"{rounded_text(low, low, high)} to {rounded_text(high, low, high)}"


def known_ends(low: float, value: float, high: float) -> tuple[float | None, float | None]:
    """Leave out ends of an interval that are farther than a factor of 1000 from the value.

    Args:
        low: Lower end (SI).
        value: The value (SI).
        high: Upper end (SI).

    Returns:
        Lower and upper end, None where it is unknown; both for a value that is not positive.
    """
    if value <= 0:
        return low, high
    above = not high < value * _FAR
    if low <= 0:  # a parameter that may be negative: its lower end is unknown if the upper one is
        return (None, None) if above else (low, high)
    return None if not low * _FAR > value else low, None if above else high


def reach_text(low: float, value: float, high: float) -> str:
    """Write how far an interval reaches from its value, shorter than `interval_text`.

    Args:
        low: Lower end (SI).
        value: The value (SI).
        high: Upper end (SI).

    Returns:
        E.g. "±0.82 %", "-26 +35 %", "factor 12", "above 2.1"; the interval itself where the value is not positive.
    """
    text = interval_text(low, value, high)
    if value <= 0 or text.startswith(("unknown", "above", "below")):
        return text
    down, up = 100 * (1 - low / value), 100 * (high / value - 1)
    if abs(up - down) <= _EVEN * up:
        return f"±{number(0.5 * (up + down), 2)} %"
    if low > 0 and high > _MANIFOLD * value:
        return f"factor {number(max(high / value, value / low), 2)}"
    return f"-{number(down, 2)} +{number(up, 2)} %"
