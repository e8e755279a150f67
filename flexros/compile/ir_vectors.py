"""Element-wise code over arrays of doubles, in vectors."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.compile.ir_text import IrBlock

CHUNK = 8  # doubles per vector
_UNROLLED_CHUNKS = 8


def element(block: IrBlock, base: str, position: str) -> str:
    """Write the reading of one vector of the writer's lanes from double `position` of an array on."""
    return block.value(f"load {block.type}, ptr {block.pointer(base, position, 'double')}, align 8")


def set_element(block: IrBlock, number: str, base: str, position: str) -> None:
    """Write the storing of one vector from double `position` of an array on."""
    block.emit(f"store {block.type} {number}, ptr {block.pointer(base, position, 'double')}, align 8")


def element_wise(block: IrBlock, count: int, body: Callable[[IrBlock, str], None]) -> None:
    """Write a body for all doubles of arrays, in vectors as long as possible.

    Args:
        block: Where to write.
        count: Number of doubles.
        body: Called with a writer for some lanes and the position of the first double.
    """
    whole = count - count % CHUNK
    if whole // CHUNK > _UNROLLED_CHUNKS:
        with block.loop(0, whole, CHUNK) as i:
            body(block.of_lanes(CHUNK), i.index)
    else:
        for position in range(0, whole, CHUNK):
            body(block.of_lanes(CHUNK), str(position))
    position = whole
    for width in (4, 2, 1):
        if count - position >= width:
            body(block.of_lanes(width), str(position))
            position += width
