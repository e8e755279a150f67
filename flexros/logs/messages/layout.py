"""Layout of a serialised message in which only the stamp and spans of doubles change from message to message."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from flexros.arrays import BoolArray, FloatArray, IntArray

STAMP_OFFSET = 4
"""Offset of header.stamp [byte]: the header is the first member, after the encapsulation."""

_STAMP_SIZE = 8


class Span(NamedTuple):
    """Consecutive doubles in a message: offset of the first [byte] and count."""

    offset: int
    size: int


class Unpacking(NamedTuple):
    """Unpacking of one message into a flat tuple by `unpack_from`.

    Attributes:
        struct: Format of the message; skips padding.
        constants: Expected constant bytes.
        pick_constants: Selects them from the tuple.
        stamp: Index of the seconds in the tuple; the nanoseconds follow.
        spans: Slices of the numbers of each span.
    """

    struct: struct.Struct
    constants: tuple[bytes, ...]
    pick_constants: Callable[[tuple[Any, ...]], tuple[bytes, ...]]
    stamp: int
    spans: tuple[slice, ...]


@dataclass(frozen=True)
class MessageLayout:
    """Offsets of the changing numbers of a message, and the bytes between them.

    Attributes:
        image: A message of this layout up to its last member; the values of its numbers are arbitrary.
        spans: Doubles that change, in order, after the stamp.
        padding: Begin and end of the bytes without meaning, in order; senders may leave any value there.
        order: Byte order of the numbers, "<" or ">".
    """

    image: bytes
    spans: tuple[Span, ...]
    padding: tuple[tuple[int, int], ...]
    order: str = "<"

    @cached_property
    def constants(self) -> tuple[bytes, ...]:
        """The bytes before the stamp and before each span, padding included."""
        edges = [0, STAMP_OFFSET, STAMP_OFFSET + _STAMP_SIZE]
        for span in self.spans:
            edges += [span.offset, span.offset + 8 * span.size]
        return tuple(self.image[a:b] for a, b in zip(edges[::2], edges[1::2], strict=False))

    @cached_property
    def packer(self) -> struct.Struct:
        """Packs a constant, seconds, nanoseconds, then a constant and the numbers of each span."""
        spans = "".join(f"{len(c)}s{span.size}d" for c, span in zip(self.constants[1:], self.spans, strict=True))
        return struct.Struct(f"{self.order}{len(self.constants[0])}siI{spans}")

    @cached_property
    def fixed(self) -> tuple[tuple[int, int], ...]:
        """Begin and end of the bytes that all messages of this layout have in common."""
        changing = [
            (STAMP_OFFSET, STAMP_OFFSET + _STAMP_SIZE),
            *((s.offset, s.offset + 8 * s.size) for s in self.spans),
        ]
        free = sorted([*self.padding, *changing, (len(self.image), len(self.image))])
        begins = [0, *(end for _, end in free)]
        return tuple((a, b) for a, (b, _) in zip(begins, free, strict=False) if b > a)

    @cached_property
    def unpacking(self) -> Unpacking:
        """Unpacking of one message of this layout."""
        parts = [(a, f"{b - a}s", 1) for a, b in self.fixed] + [(a, f"{b - a}x", 0) for a, b in self.padding]
        parts += [(STAMP_OFFSET, "iI", 2)] + [(s.offset, f"{s.size}d", s.size) for s in self.spans if s.size]
        parts.sort()
        # index of the first tuple entry of each part, by its offset in the message
        first = dict(zip((p[0] for p in parts), np.cumsum([0, *(p[2] for p in parts)]).tolist(), strict=False))
        return Unpacking(
            struct.Struct(self.order + "".join(code for _, code, _ in parts)),
            tuple(self.image[a:b] for a, b in self.fixed),
            itemgetter(*(first[a] for a, _ in self.fixed)),
            first[STAMP_OFFSET],
            tuple(slice(first[s.offset], first[s.offset] + s.size) if s.size else slice(0) for s in self.spans),
        )

    @cached_property
    def record(self) -> np.dtype[np.void]:
        """The message as a NumPy record with the fields sec, nanosec and span_0, span_1, ... where not empty."""
        fields = [("sec", f"{self.order}i4", STAMP_OFFSET), ("nanosec", f"{self.order}u4", STAMP_OFFSET + 4)]
        for i, span in enumerate(self.spans):
            if span.size:
                fields.append((f"span_{i}", f"({span.size},){self.order}f8", span.offset))
        names, formats, offsets = zip(*fields, strict=True)
        return np.dtype(
            {"names": list(names), "formats": list(formats), "offsets": list(offsets), "itemsize": len(self.image)}
        )

    def matches(self, messages: NDArray[np.uint8]) -> BoolArray:
        """Return which messages have this layout.

        Args:
            messages: Serialised messages of equal length, shape (n, length); bytes after the last member are ignored.

        Returns:
            Whether each has the same bytes outside the stamp, the spans and the padding, shape (n,).
        """
        same = np.full(len(messages), messages.shape[1] >= len(self.image))
        for begin, end in self.fixed:
            if not same.any():
                break
            same &= (messages[:, begin:end] == np.frombuffer(self.image[begin:end], np.uint8)).all(axis=1)
        return same

    def _records(self, messages: NDArray[np.uint8]) -> NDArray[np.void]:
        return np.ascontiguousarray(messages[:, : len(self.image)]).view(self.record)[:, 0]

    def stamps(self, messages: NDArray[np.uint8]) -> IntArray:
        """Return the stamps of messages of this layout [ns], shape (n,)."""
        records = self._records(messages)
        stamps: IntArray = records["sec"].astype(np.int64) * NANOSECONDS + records["nanosec"]
        return stamps

    def numbers(self, messages: NDArray[np.uint8], span: int) -> FloatArray:
        """Return the numbers of one span of messages of this layout, shape (n, size)."""
        if not self.spans[span].size:
            return np.empty((len(messages), 0))
        values: FloatArray = self._records(messages)[f"span_{span}"].astype(np.float64)
        return values

    def serialise(self, stamp: IntArray, numbers: Sequence[FloatArray]) -> NDArray[np.uint8]:
        """Serialise many messages at once.

        Args:
            stamp: Stamps [ns], shape (n,).
            numbers: One array per span, shape (n, size).

        Returns:
            The messages, shape (n, length).
        """
        messages = np.empty((len(stamp), len(self.image)), np.uint8)
        messages[:] = np.frombuffer(self.image, np.uint8)
        records = messages.view(self.record)[:, 0]
        records["sec"], records["nanosec"] = np.divmod(stamp, NANOSECONDS)
        for i, (span, values) in enumerate(zip(self.spans, numbers, strict=True)):
            if span.size:
                records[f"span_{i}"] = values
        return messages
