"""How the report names verdicts and numbers."""

from __future__ import annotations

from flexros.analysis.figures_table import number

VERDICT_WORDS = {"determined": "determined", "weak": "weak", "not_determined": "not determined"}
"""Verdicts as they are read."""

VERDICT_COLOURS = {"determined": "#0072b2", "weak": "#e69f00", "not_determined": "#d55e00"}
"""Colours of verdicts, to be told apart also by the colour-blind."""

_FAR = 1000.0


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


def interval_text(low: float, value: float, high: float) -> str:
    """Write an interval; an end that is farther than a factor of 1000 from the value says nothing and is left out.

    Args:
        low: Lower end (SI).
        value: The value (SI).
        high: Upper end (SI).

    Returns:
        E.g. "2.1 to 2.4", "above 2.1", "unknown".
    """
    below, above = not abs(low) * _FAR > abs(value), not abs(high) < abs(value) * _FAR
    if value > 0 and below and above:
        return "unknown"
    if value > 0 and above:
        return f"above {value_text(low)}"
    if value > 0 and low > 0 and below:
        return f"below {value_text(high)}"
    return f"{value_text(low)} to {value_text(high)}"
