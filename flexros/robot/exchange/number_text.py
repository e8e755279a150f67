"""Numbers as texts of XML attributes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


def number(value: float) -> str:
    """Write a number for an attribute, without the round-off of its last digits and without the sign of zero."""
    return repr(float(f"{value:.13g}") + 0.0).removesuffix(".0")


def numbers_text(values: Iterable[float]) -> str:
    """Write numbers for an attribute."""
    return " ".join(number(value) for value in values)
