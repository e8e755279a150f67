"""Reading and writing of CDR, the serialisation of ROS 2 messages (OMG DDS-XTypes 1.3, section 7.4)."""

from __future__ import annotations

import struct

from flexros.errors import InputError

ENCAPSULATION = b"\x00\x01\x00\x00"
"""First four bytes of a message in little-endian CDR, as all ROS 2 middlewares on little-endian machines write it."""

_OPTIONS = (2, 4)
_REPRESENTATIONS = {0: (">", 8), 1: ("<", 8), 6: (">", 4), 7: ("<", 4)}


class MessageError(InputError):
    """A serialised message that does not conform to its type; the text names the rule and the position."""


class CdrCursor:
    """Reads one serialised message from the front; every claimed size is checked before it is used.

    Fast CDR leaves padding uninitialised, so that equal messages may differ in those bytes. Bytes after the last member
    are not an error: rclpy's serialize_message sizes its result by an estimate.

    Args:
        payload: The message with its four bytes of encapsulation.

    Attributes:
        position: Offset of the next byte, counted from the start of the payload.
        order: Byte order of the numbers, "<" or ">".
        widest: Largest alignment: 8 in CDR 1, 4 in CDR 2 [byte].
        padding: Begin and end of the bytes that have no meaning, in order.
    """

    def __init__(self, payload: bytes | memoryview) -> None:
        if len(payload) < 4 or payload[0] != 0 or payload[1] not in _REPRESENTATIONS:
            raise MessageError(
                f"a message begins with the bytes {bytes(payload[:4]).hex(' ')}, allowed is plain CDR (00 00, "
                "00 01, 00 06 or 00 07); record it with a ROS 2 middleware"
            )
        self.payload = payload
        self.position = 4
        self.order, self.widest = _REPRESENTATIONS[payload[1]]
        self.padding = [_OPTIONS]
        self._uint32 = struct.Struct(self.order + "I")

    def skip(self, n_bytes: int, what: str) -> int:
        """Skip bytes and return the offset where they begin."""
        start = self.position
        if n_bytes > len(self.payload) - start:
            raise MessageError(
                f"a message ends at byte {len(self.payload)} inside {what}, which needs {n_bytes} bytes from "
                f"byte {start}; the message is truncated or of another type"
            )
        self.position = start + n_bytes
        return start

    def align(self, size: int) -> None:
        """Skip to the next multiple of `size` [byte], counted from the end of the encapsulation."""
        n_bytes = -(self.position - 4) % min(size, self.widest)
        if n_bytes:
            self.padding.append((self.position, self.position + n_bytes))
            self.position += n_bytes

    def uint32(self, what: str) -> int:
        """Read an unsigned integer."""
        self.align(4)
        value: int = self._uint32.unpack_from(self.payload, self.skip(4, what))[0]
        return value

    def string(self, what: str) -> str:
        """Read a string."""
        length = self.uint32(what)
        start = self.skip(length, what)
        raw = bytes(self.payload[start : start + length])
        try:
            return raw.rstrip(b"\0").decode()
        except UnicodeDecodeError as error:
            raise MessageError(f"a message holds {raw[:20]!r} as {what}, which is not UTF-8 text") from error

    def strings(self, what: str) -> tuple[str, ...]:
        """Read a sequence of strings."""
        count = self.uint32(what)
        if 4 * count > len(self.payload) - self.position:
            raise MessageError(f"a message of {len(self.payload)} bytes claims {count} entries of {what}")
        return tuple(self.string(what) for _ in range(count))

    def doubles(self, what: str) -> tuple[int, int]:
        """Skip a sequence of doubles; return its offset and its count."""
        count = self.uint32(what)
        if count:
            self.align(8)
        return self.skip(8 * count, what), count


class CdrBuilder:
    """Writes the constant parts of a message in little-endian CDR 1.

    Attributes:
        data: The message so far.
        padding: Begin and end of the bytes that have no meaning, in order.
    """

    def __init__(self) -> None:
        self.data = bytearray(ENCAPSULATION)
        self.padding = [_OPTIONS]

    def align(self, size: int) -> None:
        """Pad with zeros to a multiple of `size` [byte]."""
        n_bytes = -(len(self.data) - 4) % size
        if n_bytes:
            self.padding.append((len(self.data), len(self.data) + n_bytes))
            self.data.extend(bytes(n_bytes))

    def uint32(self, value: int) -> None:
        """Write an unsigned integer."""
        self.align(4)
        self.data.extend(struct.pack("<I", value))

    def string(self, text: str) -> None:
        """Write a string with its terminating zero."""
        raw = text.encode() + b"\0"
        self.uint32(len(raw))
        self.data.extend(raw)

    def strings(self, texts: tuple[str, ...]) -> None:
        """Write a sequence of strings."""
        self.uint32(len(texts))
        for text in texts:
            self.string(text)

    def doubles(self, count: int) -> int:
        """Write a sequence of zeros as doubles; return the offset of the first."""
        self.uint32(count)
        if count:
            self.align(8)
        start = len(self.data)
        self.data.extend(bytes(8 * count))
        return start
