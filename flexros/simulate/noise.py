"""Sensor noise: white, normal, a pure function of seed and sample index."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from flexros.simulate.sample_blocks import BLOCK, SampleBlocks, Zeros

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class Stream(IntEnum):
    """Independent streams of random numbers of one seed."""

    ENCODER = 0
    TOOL = 1
    DISTURBANCE = 2
    EXCITATION = 3


def generator(seed: int, *stream: int) -> np.random.Generator:
    """Make the random generator of one stream of a seed.

    Args:
        seed: Seed of the run, 0 or more.
        stream: Numbers that tell the streams apart, e.g. a stream and a block number.

    Returns:
        Generator that depends on these numbers alone.
    """
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=stream)))


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
