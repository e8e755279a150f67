"""Sensor noise: white, normal, a pure function of seed and sample index."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.random_streams import Stream, generator
from flexros.simulate.sample_blocks import BLOCK, SampleBlocks, Zeros

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def white_noise(rms: FloatArray, seed: int, stream: Stream) -> SampleBlocks:
    """Make white normal noise.

    Args:
        rms: Standard deviation of each channel, shape (width,).
        seed: Seed of the run.
        stream: Which of the seed's streams.

    Returns:
        The noise by sample index.
    """
    width = len(rms)
    if not np.any(rms):
        return Zeros(width)

    def make_block(number: int) -> FloatArray:
        return generator(seed, stream, number).standard_normal((BLOCK, width)) * rms

    return SampleBlocks(make_block, width)
