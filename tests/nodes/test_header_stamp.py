"""Stamps of serialised messages."""

from __future__ import annotations

import struct

import pytest

from flexros_nodes.header_stamp import header_stamp


@pytest.mark.parametrize(("order", "flag"), [("<", 1), (">", 0), ("<", 7)])
def test_stamp_is_read_in_either_byte_order(order: str, flag: int) -> None:
    message = bytes((0, flag, 0, 0)) + struct.pack(f"{order}iI", 12, 345_678_901) + bytes(20)
    assert header_stamp(message) == 12_345_678_901
