"""Check of the elements of a MATLAB file of version 5 to 7 before SciPy unpacks them.

SciPy trusts every size in such a file: it unpacks without limit, and follows nested structures until the stack
overflows, which ends the process. (MATLAB, "MAT-File Format", chapter 1: an element has a tag of type and size; a
matrix consists of the elements flags, dimensions and name, and what its class says.)
"""

from __future__ import annotations

import math
import struct
import zlib
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_STRUCTURE, MOST_ELEMENTS, room_of

if TYPE_CHECKING:
    from pathlib import Path

_HEAD = 128
_MATRIX, _COMPRESSED = 14, 15
_CELL, _STRUCTURE, _OBJECT, _TEXT, _SPARSE, _FUNCTION, _OPAQUE = 1, 2, 3, 4, 5, 16, 17
_COMPLEX = 1 << 11
_PLAIN = (1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18)
"""Types of elements with numbers or text; SciPy looks up every other type beyond the end of its table."""


def check_elements(path: Path) -> None:
    """Refuse a file that unpacks to more than its size allows, or nests too deeply; version 4 has neither feature.

    Args:
        path: The file.

    Raises:
        InputError: It is damaged or beyond a limit.
    """
    room = room_of(path.stat().st_size)
    with path.open("rb") as file:
        head = file.read(_HEAD)
        if len(head) < _HEAD or 0 in head[:4]:  # version 4, whose arrays are neither compressed nor nested
            return
        order = "<" if head[126:128] == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            data = file.read(min(size, path.stat().st_size))
            if kind == _COMPRESSED:
                data = _unpacked(data, room)
                room -= len(data)
            else:
                data = tag + data
            _Elements(data, order).check()


def _unpacked(data: bytes, room: int) -> bytes:
    unpacked = zlib.decompressobj().decompress(data, room + 1)
    if len(unpacked) > room:
        raise InputError("its arrays unpack to more bytes than are allowed for a file of this size")
    return unpacked


class _Elements:
    """Elements of one variable, in the order in which SciPy reads them.

    Args:
        data: The variable.
        order: Byte order, "<" or ">".
    """

    def __init__(self, data: bytes, order: str) -> None:
        self._data = data
        self._order = order
        self._position = 0

    def check(self) -> None:
        """Check all nested matrices."""
        waiting = [1]
        n_matrices = 0
        while waiting:
            if not waiting[-1]:
                waiting.pop()
                continue
            waiting[-1] -= 1
            n_matrices += 1
            within = self._matrix()
            if n_matrices + within > MOST_ELEMENTS:
                raise InputError(f"it holds more than {MOST_ELEMENTS} arrays and structures")
            if within and len(waiting) == DEEPEST_STRUCTURE:
                raise InputError(f"its structures nest more than {DEEPEST_STRUCTURE} levels deep")
            waiting.append(within)

    def _words(self) -> tuple[int, int]:
        if self._position + 8 > len(self._data):
            raise InputError("a variable is truncated")
        first, second = struct.unpack_from(f"{self._order}II", self._data, self._position)
        self._position += 8
        return first, second

    def _element(self) -> bytes:
        """Skip an element and return its data; a small one is contained in its tag."""
        start = self._position
        kind, size = self._words()
        if kind & 0xFFFF not in _PLAIN or (kind >> 16) > 4:
            raise InputError(f"a variable holds an element of the unknown type {kind}")
        if kind >> 16:
            return self._data[start + 4 : start + 4 + (kind >> 16)]
        start, self._position = self._position, self._position + size + -size % 8
        return self._data[start : start + size]

    def _matrix(self) -> int:
        """Skip the own elements of a matrix; return the number of matrices in it, which follow."""
        kind, size = self._words()
        if kind != _MATRIX:
            raise InputError(f"a variable holds an element of type {kind} where an array should be")
        if not size:
            return 0
        self._words()
        flags, _ = self._words()
        number = flags & 0xFF
        if number == _OPAQUE:
            return self._after(3, 1)
        dimensions = self._element()
        n_entries: int = math.prod(struct.unpack_from(f"{self._order}{len(dimensions) // 4}I", dimensions))
        self._element()
        if number == _CELL:
            return n_entries
        if number == _FUNCTION:
            return 1
        if number in (_STRUCTURE, _OBJECT):
            return self._structure(number, n_entries)
        n_parts = 2 if flags & _COMPLEX and number != _TEXT else 1
        return self._after(n_parts + (2 if number == _SPARSE else 0), 0)

    def _structure(self, number: int, n_entries: int) -> int:
        if number == _OBJECT:
            self._element()
        length = int.from_bytes(self._element()[:4], "little" if self._order == "<" else "big")
        n_fields = len(self._element()) // max(length, 1)
        if n_entries > MOST_ELEMENTS:
            raise InputError(f"a structure claims {n_entries} entries, allowed are {MOST_ELEMENTS}")
        return n_entries * n_fields

    def _after(self, n_elements: int, within: int) -> int:
        for _ in range(n_elements):
            self._element()
        return within
