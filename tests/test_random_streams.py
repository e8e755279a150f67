"""Streams of random numbers: the same for the same numbers, others for others."""

from __future__ import annotations

from flexros.random_streams import Stream, generator


def test_numbers_depend_on_seed_stream_and_block_alone() -> None:
    drawn = {
        numbers: generator(*numbers).standard_normal()
        for numbers in [(1, Stream.ENCODER, 0), (2, Stream.ENCODER, 0), (1, Stream.TOOL, 0), (1, Stream.ENCODER, 1)]
    }
    assert len(set(drawn.values())) == 4
    assert generator(1, Stream.ENCODER, 0).standard_normal() == drawn[1, Stream.ENCODER, 0]
