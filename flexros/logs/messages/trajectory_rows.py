"""trajectory_msgs/msg/JointTrajectory read point by point: a loop in real time has no time to decode a whole one."""

from __future__ import annotations

import math
import struct
from functools import lru_cache
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexros.logs.cdr_cursor import CdrCursor, MessageError
from flexros.logs.messages.joint_trajectory import FIELDS
from flexros.logs.stamps import NANOSECONDS, stamp_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

_TAKEN = ("positions", "velocities", "effort")


class _Point(NamedTuple):
    """A point as a format, where its sizes and its values are among the unpacked numbers, what its sizes must be."""

    format: struct.Struct
    sizes: tuple[int, ...]
    sizes_of: itemgetter[tuple[int, ...]]
    row_of: itemgetter[tuple[float, ...]]
    next_offset: int


@lru_cache(maxsize=64)
def _point(offset: int, joints: int, filled: tuple[bool, ...]) -> _Point:
    """Lay out a point that begins at an offset modulo 8 after the encapsulation, in little-endian CDR 1."""
    text, places, start, at = "<", [], offset, 0
    for is_filled in filled:
        text += "I"
        places.append(at)
        offset, at = offset + 4, at + 1
        if is_filled:
            text += f"{-offset % 8}x{joints}d"
            offset, at = offset + -offset % 8 + 8 * joints, at + joints
    form = struct.Struct(text + "iI")
    assert form.size == offset + 8 - start
    sizes = tuple(joints if is_filled else 0 for is_filled in filled)
    begins = [place + 1 for place, is_filled in zip(places, filled, strict=True) if is_filled]
    row_of = itemgetter(*(begin + joint for begin in begins for joint in range(joints)))
    return _Point(form, sizes, itemgetter(*places), row_of, (offset + 8) % 8)


class TrajectoryRows:
    """Points of a message, one per sample, each decoded when it is used.

    Args:
        payload: The message.
        names: Required joint names, in this order.
        sample_time: Time between two points [s].

    Attributes:
        first: Stamp of the first point [ns].
        last: Stamp of the last point [ns].

    Raises:
        MessageError: The message has another form: other names or order, another representation, points that are empty
            in one of positions, velocities and effort or fill accelerations, or that are not one sample time apart.
            `read_joint_trajectory` reads it, or states what is wrong.
    """

    def __init__(self, payload: bytes, names: Sequence[str], sample_time: float) -> None:
        cursor = CdrCursor(payload)
        self._stamp = stamp_of(payload)
        cursor.skip(8, "header.stamp")
        cursor.string("header.frame_id")
        own = cursor.strings("joint_names")
        self._n = cursor.uint32("points")
        self._payload, self._names = payload, tuple(names)
        self._begin = cursor.position
        filled = tuple(field in _TAKEN for field in FIELDS)
        self._head = _point((self._begin - 4) % 8, len(own), filled)
        self._point = _point(self._head.next_offset, len(own), filled)
        size = self._head.format.size + (self._n - 1) * self._point.format.size
        if own != self._names or not self._n or cursor.order != "<" or cursor.widest != 8:
            raise MessageError("the joints of a JointTrajectory differ from those required, or it has no points")
        cursor.skip(size, "its points")
        self.first, self.last = self._time(0), self._time(self._n - 1)
        self._step = sample_time * 1e9
        if abs(self.last - self.first - (self._n - 1) * self._step) > 1.0:
            raise MessageError("the points of a JointTrajectory are not one sample time apart")

    def __len__(self) -> int:
        return self._n

    def _values(self, number: int) -> tuple[float, ...]:
        """Return all numbers of a point, with the sizes of its fields."""
        point, begin = self._head, self._begin
        if number:
            point, begin = self._point, begin + self._head.format.size + (number - 1) * self._point.format.size
        values = point.format.unpack_from(self._payload, begin)
        if point.sizes_of(values) != point.sizes:
            raise MessageError(
                "the points of a JointTrajectory differ in the fields that they fill; fill a field in all or in none"
            )
        return values

    def _time(self, number: int) -> int:
        values = self._values(number)
        return self._stamp + int(values[-2]) * NANOSECONDS + int(values[-1])

    def row(self, stamp: int) -> FloatArray | None:
        """Return position, velocity and torque of a stamp [ns], shape (3 M,); None where no point has this stamp.

        Raises:
            MessageError: The fields of the point differ from those of the first.
        """
        if not self.first <= stamp <= self.last:
            return None
        number = round((stamp - self.first) / self._step)
        values = self._values(number)
        if self._stamp + int(values[-2]) * NANOSECONDS + int(values[-1]) != stamp:
            return None
        row = self._point.row_of(values)
        if not math.isfinite(sum(row)):
            raise MessageError(f"a point of a JointTrajectory at {stamp} ns has a value that is not a finite number")
        return np.array(row)
