"""Detection of divergence in the compiled loop, per lane."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.compile.ir_text import CHUNK, element, mask_type

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.compile.ir_text import IrBlock


def stop_when_diverged(block: IrBlock, states: int, plant: str, diverged: str, k: str) -> None:
    """Write code that stores sample k + 1 for lanes whose state is not finite, and returns once all have diverged.

    Args:
        block: Where to write, in a function that returns i64.
        states: Number of plant states.
        plant: Address of the state.
        diverged: Address of the first bad sample per lane, -1 where none.
        k: Sample, an i64 value.
    """
    bad = _not_finite(block, states, plant)
    with block.when(_any(block, bad)):
        after = block.value(f"add nsw i64 {k}, 1")
        kind, mask = block.integer, block.mask
        none = block.splat_integer("-1")
        before = block.value(f"load {kind}, ptr {diverged}, align 8")
        fresh = block.value(f"and {mask} {bad}, {block.value(f'icmp eq {kind} {before}, {none}')}")
        noted = block.value(f"select {mask} {fresh}, {kind} {block.splat_integer(after)}, {kind} {before}")
        block.emit(f"store {kind} {noted}, ptr {diverged}, align 8")
        left = _any(block, block.value(f"icmp eq {kind} {noted}, {none}"))
        block.leave_when(block.value(f"xor i1 {left}, true"), f"ret i64 {after}")


def _any(block: IrBlock, mask: str) -> str:
    """Reduce a mask to one bit: whether it is set in any lane."""
    if block.lanes == 1:
        return mask
    bits = block.value(f"bitcast {block.mask} {mask} to i{block.lanes}")
    return block.value(f"icmp ne i{block.lanes} {bits}, 0")


def _not_finite(block: IrBlock, states: int, plant: str) -> str:
    """Return one bit per lane: whether any state is infinite or NaN (then 0 x is not 0)."""
    masks = []
    for width, positions in _sums(states, block.lanes):
        part = block.of_lanes(width)
        total = part.number(0.0)
        for position in positions:
            total = part.add(total, part.mul(element(part, plant, str(position)), part.number(0.0)))
        bad = part.compare("une", total, part.number(0.0))
        masks.append(bad if width == block.lanes else _any(part, bad))
    result = masks[0]
    for mask in masks[1:]:
        result = block.value(f"or {mask_type(block.lanes)} {result}, {mask}")
    return result


def _sums(states: int, lanes: int) -> Sequence[tuple[int, list[int]]]:
    """Split the state into independent sums, which run in parallel: (lanes of the sum, first doubles)."""
    if lanes > 1:
        return [(lanes, [k * lanes for k in range(start, states, 4)]) for start in range(min(4, states))]
    whole = states - states % CHUNK
    chunks = [(CHUNK, list(range(0, whole, CHUNK)))] if whole else []
    return chunks + ([(1, list(range(whole, states)))] if states > whole else [])
