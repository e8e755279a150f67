"""Signals by sample index, the same however the samples are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

BLOCK = 1024
"""Samples made at once [1]."""


class SampleBlocks:
    """Signal made in blocks of fixed place and length.

    A plant asks sample by sample, a whole run in slices of any length. Both must see the same numbers to the last
    bit, so every block is made from its number alone, and asking only cuts from blocks.

    Args:
        make_block: Gives block b, samples b * BLOCK to (b + 1) * BLOCK - 1, shape (BLOCK, width).
        width: Number of columns.
    """

    def __init__(self, make_block: Callable[[int], FloatArray], width: int) -> None:
        self.width = width
        self._make_block = make_block
        self._number = -1
        self._block = np.empty((BLOCK, width))

    def rows(self, first: int, n: int) -> FloatArray:
        """Cut samples.

        Args:
            first: Index of the first sample, 0 or more.
            n: Number of samples.

        Returns:
            Samples first to first + n - 1, shape (n, width), contiguous.
        """
        rows = np.empty((n, self.width))
        done = 0
        while done < n:
            number, offset = divmod(first + done, BLOCK)
            taken = min(BLOCK - offset, n - done)
            rows[done : done + taken] = self.block(number)[offset : offset + taken]
            done += taken
        return rows

    def row(self, index: int) -> FloatArray:
        """Give one sample, shape (width,); not to be written to."""
        row: FloatArray = self.block(index // BLOCK)[index % BLOCK]
        return row

    def block(self, number: int) -> FloatArray:
        """Give one block, shape (BLOCK, width); not to be written to."""
        if number != self._number:
            self._block = self._make_block(number)
            self._number = number
        return self._block


class Zeros(SampleBlocks):
    """The signal that is zero at all samples; known as such, so that a plant can pass it over.

    Args:
        width: Number of columns.
    """

    def __init__(self, width: int) -> None:
        block = np.zeros((BLOCK, width))
        super().__init__(lambda number: block, width)
