"""Numbers as text: significant digits, per cent."""

from __future__ import annotations

import numpy as np


def number(value: float | None, digits: int = 4) -> str:
    """Format a number with significant digits; integers in full, "-" for None or not finite."""
    if value is None or not np.isfinite(value):
        return "-"
    if value == round(value) and abs(value) < 1e15:
        return str(round(value))
    if abs(value) >= 1e6 or abs(value) < 1e-4:
        return f"{value:.{digits - 1}e}"
    decimals = max(digits - 1 - int(np.floor(np.log10(abs(value)))), 0)
    return f"{value:.{decimals}f}"


def percent(share: float, digits: int = 3) -> str:
    """Format a share in per cent, ">1000" above a factor of ten.

    Args:
        share: The share [1].
        digits: Significant digits.

    Returns:
        E.g. "2.31", ">1000".
    """
    return ">1000" if not share <= 10 else number(100 * share, digits)
