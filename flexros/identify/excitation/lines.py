"""Excited lines of a multisine, and lines left empty to detect nonlinear distortions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import IntArray


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines as multiples of one over the period; each array increases.

    Attributes:
        excited: Lines with energy, shape (F,).
        odd_detection: Odd lines without energy within the band, shape (n_odd,).
        even_detection: Even lines without energy within the band, shape (n_even,).
    """

    excited: IntArray
    odd_detection: IntArray
    even_detection: IntArray

    @classmethod
    def of(cls, excited: IntArray) -> Lines:
        """Classify all lines between the lowest and the highest excited one."""
        excited = np.unique(excited).astype(np.int64)
        rest = np.setdiff1d(np.arange(excited[0], excited[-1] + 1), excited)
        return cls(excited, rest[rest % 2 == 1], rest[rest % 2 == 0])

    def without(self, line: int) -> Lines:
        """Return the lines with one removed from the detection lines."""
        odd, even = (lines[lines != line] for lines in (self.odd_detection, self.even_detection))
        return Lines(self.excited, odd, even)


def candidate_lines(lowest: float, highest: float, odd: bool, source: str) -> IntArray:
    """List the lines of a band.

    Args:
        lowest: Lower end [lines].
        highest: Upper end [lines].
        odd: Odd lines only.
        source: Name of the band, for the message.

    Returns:
        Lines, shape (n,).

    Raises:
        InputError: The band contains no line.
    """
    first, last = max(int(np.ceil(lowest - 1e-6)), 1), int(np.floor(highest + 1e-6))
    lines = np.arange(first, last + 1, dtype=np.int64)
    lines = lines[lines % 2 == 1] if odd else lines
    if lines.size == 0:
        raise InputError(
            f"{source} contains no {'odd ' if odd else ''}line of the period; widen the band or lengthen the period"
        )
    return lines


def spread(candidates: IntArray, number: int | None, logarithmic: bool) -> IntArray:
    """Choose lines spread evenly over a band, or evenly over its logarithm.

    Args:
        candidates: Lines to choose from, shape (n,).
        number: Number of lines; None takes all, or on a logarithmic grid as many goals as there are candidates.
        logarithmic: Even over the logarithm of frequency; the nearest candidates, without duplicates.

    Returns:
        At most `number` lines, including both ends, shape (F,).
    """
    if number is None and not logarithmic:
        return candidates
    wanted = len(candidates) if number is None else number
    space = np.geomspace if logarithmic else np.linspace
    goals = space(float(candidates[0]), float(candidates[-1]), wanted)
    chosen: IntArray = np.unique(candidates[np.argmin(np.abs(candidates[:, None] - goals), axis=0)])
    return chosen


def with_detection(chosen: IntArray, group: int, random: np.random.Generator) -> IntArray:
    """Remove one line at random from every group of neighbours (Schoukens et al. 2005).

    Args:
        chosen: Lines, shape (F,).
        group: Size of a group. The last one may be smaller and then is kept whole, as are both ends of the band and a
            group that consists only of these.
        random: Random generator of the choice.

    Returns:
        The remaining lines, at least F - F / group, in order.
    """
    keep = np.ones(len(chosen), dtype=bool)
    for first in range(0, len(chosen) - group + 1, group):
        inner = [k for k in range(first, first + group) if 0 < k < len(chosen) - 1]
        if inner:
            keep[inner[int(random.integers(len(inner)))]] = False
    return chosen[keep]
