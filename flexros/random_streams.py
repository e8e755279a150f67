"""Random numbers as pure functions of a seed, in independent streams."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """Independent streams of random numbers of one seed."""

    ENCODER = 0
    TOOL = 1
    DISTURBANCE = 2
    EXCITATION = 3
    BLIND_DEVELOPMENT = 4
    BLIND_EVALUATION = 5
    FURTHER_SENSORS = 6


def generator(seed: int, *stream: int) -> np.random.Generator:
    """Return the random generator of one stream of a seed.

    Args:
        seed: Seed of the run, 0 or more.
        stream: Numbers that identify the stream, e.g. a `Stream` and a block index.
    """
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=stream)))
