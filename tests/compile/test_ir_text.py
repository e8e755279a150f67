from __future__ import annotations

import doctest
import struct

import pytest

from flexros.compile import ir_text
from flexros.compile.ir_text import IrBlock, float_literal


def test_example_of_the_documentation_is_true() -> None:
    assert doctest.testmod(ir_text).attempted > 0
    assert doctest.testmod(ir_text).failed == 0


@pytest.mark.parametrize("value", [0.1, -0.0, 5e-324, float("inf"), 1e300])
def test_literals_keep_every_bit(value: float) -> None:
    assert struct.pack(">Q", int(float_literal(value), 16)) == struct.pack(">d", value)


def test_literal_is_repeated_for_every_lane() -> None:
    assert float_literal(1.0, 2) == "<double 0x3FF0000000000000, double 0x3FF0000000000000>"


def test_writers_of_other_lanes_share_the_block_without_sharing_names() -> None:
    block = IrBlock()
    names = {block.add("%a", "%b"), block.of_lanes(4).add("%c", "%d"), block.add("%a", "%b")}
    assert len(names) == 3
    assert len(block.text().splitlines()) == 3
    assert block.of_lanes(4).of_lanes(1) is block
