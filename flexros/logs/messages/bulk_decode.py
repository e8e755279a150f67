"""Decoding of all messages of a topic into columns, many at once.

Messages of one sender nearly always have one layout: the same length and the same bytes outside the stamp and the
numbers. Such messages are decoded as one NumPy array; a new layout is read from the first message that has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

import numpy as np

from flexros.input_limits import MOST_LAYOUTS
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.message_block import LENGTH_FIELD_END, MESSAGE_HEADER, slices
from flexros.logs.skipped_messages import SkippedMessages

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.message_block import MessageBlock
    from flexros.logs.messages.layout import MessageLayout

_HEADER_SIZE = MESSAGE_HEADER.itemsize - LENGTH_FIELD_END
_KEPT_LAYOUTS = 64  # chosen: with more layouts, the constant bytes of a topic change with every message


def payloads_of(block: MessageBlock, rows: IntArray) -> list[bytes]:
    """Return messages of a block.

    Args:
        block: Messages of a chunk.
        rows: Their rows in the block, shape (n,).

    Returns:
        Their serialised bytes, length n.
    """
    begin = block.offsets[rows]
    end = begin + block.headers["length"][rows].astype(np.int64) - _HEADER_SIZE
    return [bytes(block.data[a:b]) for a, b in zip(begin.tolist(), end.tolist(), strict=True)]


class TopicLayout(Protocol):
    """Layout of the messages of a type, with the meaning of its constant bytes."""

    @property
    def message(self) -> MessageLayout:
        """Offsets of the numbers."""


L = TypeVar("L", bound=TopicLayout)


@dataclass(frozen=True, eq=False)
class Segment(Generic[L]):
    """Messages of one layout.

    Attributes:
        layout: Their layout.
        order: Index of each message in the topic, shape (n,).
        log_time: Log times [ns], shape (n,).
        stamp: header.stamp [ns], shape (n,).
        numbers: The doubles of each span, shape (n, size).
    """

    layout: L
    order: IntArray
    log_time: IntArray
    stamp: IntArray
    numbers: tuple[FloatArray, ...]


class TopicDecoder(Generic[L]):
    """Decoder of the messages of one topic.

    Args:
        read_layout: Returns the layout of a message, or raises MessageError.

    Attributes:
        segments: The messages decoded so far.
        n_messages: Number of all messages, including damaged ones.
        damaged: Number of damaged messages, and the first reason.
    """

    def __init__(self, read_layout: Callable[[bytes | memoryview], L]) -> None:
        self._read_layout = read_layout
        self._layouts: list[L] = []
        self._n_layouts = 0
        self.segments: list[Segment[L]] = []
        self.n_messages = 0
        self.damaged = SkippedMessages()

    def add(self, block: MessageBlock, rows: IntArray, translate: Callable[[bytes], bytes] | None = None) -> None:
        """Decode messages of the topic.

        Args:
            block: Messages of a chunk.
            rows: Rows of the topic in the block.
            translate: Converts a message of another definition to the common one; None if it has that already.
        """
        order = self.n_messages + np.arange(len(rows))
        self.n_messages += len(rows)
        log_time = block.headers["log_time"][rows].astype(np.int64)
        data: bytes | memoryview = block.data
        begins, lengths = block.offsets[rows], block.headers["length"][rows].astype(np.int64) - _HEADER_SIZE
        if translate is not None:
            payloads = payloads_of(block, rows)
            kept = [i for i, payload in enumerate(payloads) if self._translate(payloads, i, payload, translate)]
            payloads, order, log_time = [payloads[i] for i in kept], order[kept], log_time[kept]
            data, lengths = b"".join(payloads), np.fromiter(map(len, payloads), np.int64, len(payloads))
            begins = np.cumsum(lengths) - lengths
        for length in np.unique(lengths).tolist():
            same = np.flatnonzero(lengths == length)
            messages = slices(data, begins[same], length) if length else np.zeros((len(same), 0), np.uint8)
            self._decode(messages, order[same], log_time[same])

    def _translate(self, payloads: list[bytes], i: int, payload: bytes, translate: Callable[[bytes], bytes]) -> bool:
        try:
            payloads[i] = translate(payload)
        except MessageError as error:
            self.damaged.add(str(error))
            return False
        return True

    def _decode(self, messages: NDArray[np.uint8], order: IntArray, log_time: IntArray) -> None:
        left = np.arange(len(messages))
        for layout in self._layouts:
            if not len(left):
                return
            left = self._decode_matching(layout, messages, left, order, log_time)
        while len(left):
            if self._n_layouts == MOST_LAYOUTS:
                self.damaged.add(f"the topic has more than {MOST_LAYOUTS} message layouts", len(left))
                return
            try:
                layout = self._read_layout(messages[left[0]].tobytes())
            except MessageError as error:
                self.damaged.add(str(error))
                left = left[1:]
                continue
            self._n_layouts += 1
            if len(self._layouts) < _KEPT_LAYOUTS:
                self._layouts.append(layout)
                left = self._decode_matching(layout, messages, left, order, log_time)
            else:
                self._decode_matching(layout, messages, left[:1], order, log_time)
                left = left[1:]

    def _decode_matching(
        self, layout: L, messages: NDArray[np.uint8], left: IntArray, order: IntArray, log_time: IntArray
    ) -> IntArray:
        """Decode the messages that have the layout; return the rows of the others."""
        candidates = messages if len(left) == len(messages) else messages[left]
        matching = layout.message.matches(candidates)
        if not matching.any():
            return left
        rows, decoded = left, candidates
        if not matching.all():
            rows, decoded = left[matching], candidates[matching]
        numbers = tuple(layout.message.numbers(decoded, i) for i in range(len(layout.message.spans)))
        stamp, received = layout.message.stamps(decoded), log_time[rows]
        received = stamp if np.array_equal(stamp, received) else received  # in lock-step: memory of a long log
        self.segments.append(Segment(layout, order[rows], received, stamp, numbers))
        return left[~matching]
