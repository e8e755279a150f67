"""Samples do not depend on the blocks in which they are requested."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flexros.random_streams import Stream
from flexros.simulate.sample_blocks import BLOCK, SampleBlocks, Zeros
from flexros.simulate.signals import white_noise

WHOLE = white_noise(np.array([1.0, 2.0]), 7, Stream.ENCODER).rows(0, 4 * BLOCK)


@settings(max_examples=30, deadline=None)
@given(cuts=st.lists(st.integers(1, 1500), min_size=1, max_size=4))
def test_slices_join_to_the_whole(cuts: list[int]) -> None:
    signal = white_noise(np.array([1.0, 2.0]), 7, Stream.ENCODER)
    first, parts = 0, []
    for n in cuts:
        n = min(n, len(WHOLE) - first)
        parts.append(signal.rows(first, n))
        first += n
    assert np.array_equal(np.vstack(parts), WHOLE[:first])


def test_samples_can_be_asked_for_backwards() -> None:
    signal = white_noise(np.array([1.0, 2.0]), 7, Stream.ENCODER)
    assert np.array_equal(signal.rows(3 * BLOCK - 1, 2), WHOLE[3 * BLOCK - 1 : 3 * BLOCK + 1])
    assert np.array_equal(signal.rows(0, 3), WHOLE[:3])


def test_each_block_is_made_once_when_read_forwards() -> None:
    made: list[int] = []

    def make_block(number: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        made.append(number)
        return np.zeros((BLOCK, 1))

    signal = SampleBlocks(make_block, 1)
    for index in range(2 * BLOCK):
        signal.rows(index, 1)
    assert made == [0, 1]


def test_zero_signal() -> None:
    assert not np.any(Zeros(3).rows(BLOCK - 1, 5))
    assert Zeros(3).rows(5, 2).shape == (2, 3)
