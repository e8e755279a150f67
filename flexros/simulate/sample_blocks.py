"""Signals by sample index, independent of the order in which samples are requested."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

BLOCK = 1024
"""Samples per block [1]."""


class SampleBlocks:
    """Signal generated in blocks of fixed position and length.

    A plant requests sample by sample, a whole run in slices of any length. Both must get the same values to the last
    bit, so every block depends on its index alone, and requests return parts of blocks.

    Args:
        make_block: Returns block b, samples b * BLOCK to (b + 1) * BLOCK - 1, shape (BLOCK, width).
        width: Number of columns.
    """

    def __init__(self, make_block: Callable[[int], FloatArray], width: int) -> None:
        self.width = width
        self._make_block = make_block
        self._number = -1
        self._block = np.empty((BLOCK, width))

    def rows(self, first: int, n: int) -> FloatArray:
        """Return samples first to first + n - 1, shape (n, width), contiguous."""
        rows = np.empty((n, self.width))
        done = 0
        while done < n:
            number, offset = divmod(first + done, BLOCK)
            taken = min(BLOCK - offset, n - done)
            rows[done : done + taken] = self.block(number)[offset : offset + taken]
            done += taken
        return rows

    def row(self, index: int) -> FloatArray:
        """Return one sample, shape (width,); read-only."""
        row: FloatArray = self.block(index // BLOCK)[index % BLOCK]
        return row

    def block(self, number: int) -> FloatArray:
        """Return one block, shape (BLOCK, width); read-only."""
        if number != self._number:
            self._block = self._make_block(number)
            self._number = number
        return self._block


class Zeros(SampleBlocks):
    """The zero signal, recognisable so that a plant can skip it."""

    def __init__(self, width: int) -> None:
        block = np.zeros((BLOCK, width))
        super().__init__(lambda number: block, width)
