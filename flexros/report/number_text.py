"""Numbers as text: significant digits, per cent."""

from __future__ import annotations

import numpy as np


def number(value: float | None, digits: int = 4) -> str:
    """Write a number with so many significant digits; whole numbers as such, "-" for none."""
    if value is None or not np.isfinite(value):
        return "-"
    if value == round(value) and abs(value) < 1e15:
        return str(round(value))
    if abs(value) >= 1e6 or abs(value) < 1e-4:
        return f"{value:.{digits - 1}e}"
    decimals = max(digits - 1 - int(np.floor(np.log10(abs(value)))), 0)
    return f"{value:.{decimals}f}"


def percent(share: float, digits: int = 3) -> str:
    """Write a share in per cent; what is beyond a factor of ten as such.

    Args:
        share: The share [1].
        digits: Significant digits.

    Returns:
        E.g. "2.31", ">1000".
    """
    return ">1000" if not share <= 10 else number(100 * share, digits)
