"""trajectory_msgs/msg/JointTrajectory: whole chunks of points serialised and parsed as NumPy records."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple, final

import numpy as np

from flexros.errors import InputError
from flexros.logs.cdr_cursor import CdrBuilder, CdrCursor, MessageError
from flexros.logs.messages.codec import AbstractCodec
from flexros.logs.messages.layout import STAMP_OFFSET
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flexros.arrays import FloatArray, IntArray

FIELDS = ("positions", "velocities", "accelerations", "effort")


@dataclass(frozen=True, eq=False)
class JointTrajectoryChunk:
    """Points of a joint trajectory; a field is None where the points leave it empty.

    Attributes:
        stamp_ns: header.stamp, the origin of time_from_start [ns].
        names: Joint names, length n_joints.
        time_from_start: Times after the stamp [ns], shape (n,).
        positions: Positions [rad or m], shape (n, n_joints).
        velocities: Velocities [rad/s or m/s], shape (n, n_joints).
        accelerations: Accelerations [rad/s^2 or m/s^2], shape (n, n_joints).
        effort: Torques or forces [Nm or N], shape (n, n_joints).
        frame_id: header.frame_id.
    """

    stamp_ns: int
    names: tuple[str, ...]
    time_from_start: IntArray
    positions: FloatArray | None = None
    velocities: FloatArray | None = None
    accelerations: FloatArray | None = None
    effort: FloatArray | None = None
    frame_id: str = ""

    def __post_init__(self) -> None:
        shape = (len(self.time_from_start), len(self.names))
        for field in FIELDS:
            array = getattr(self, field)
            if array is not None and array.shape != shape:
                raise InputError(
                    f"JointTrajectoryChunk.{field} has shape {array.shape}, allowed is {shape}; give one row per point"
                )

    def in_order(self, names: Sequence[str]) -> JointTrajectoryChunk:
        """Return the same points with the joints in the order of `names`; further joints are left out.

        Raises:
            MessageError: The trajectory lacks a joint.
        """
        if tuple(names) == self.names:
            return self
        missing = [name for name in names if name not in self.names]
        if missing:
            raise MessageError(f"a JointTrajectory lacks {', '.join(missing)}; it has {', '.join(self.names)}")
        columns = [self.names.index(name) for name in names]
        values = {f: getattr(self, f) for f in FIELDS}
        return JointTrajectoryChunk(
            self.stamp_ns,
            tuple(names),
            self.time_from_start,
            frame_id=self.frame_id,
            **{field: None if array is None else array[:, columns] for field, array in values.items()},
        )


class _PointLayout(NamedTuple):
    """A point as a NumPy record, and the offset modulo 8 at which the next one begins."""

    record: np.dtype[np.void]
    next_offset: int


@lru_cache(maxsize=64)
def _point_layout(offset: int, sizes: tuple[int, ...], order: str = "<", widest: int = 8) -> _PointLayout:
    start = offset
    fields: list[tuple[str, str, int]] = []
    for name, size in zip(FIELDS, sizes, strict=True):
        fields.append((f"{name}_size", f"{order}u4", offset - start))
        offset += 4
        if size:
            offset += -offset % widest
            fields.append((name, f"({size},){order}f8", offset - start))
            offset += 8 * size
    fields += [("sec", f"{order}i4", offset - start), ("nanosec", f"{order}u4", offset + 4 - start)]
    names, formats, offsets = zip(*fields, strict=True)
    size = offset + 8 - start
    record = np.dtype({"names": list(names), "formats": list(formats), "offsets": list(offsets), "itemsize": size})
    return _PointLayout(record, (offset + 8) % 8)


def _points(chunk: JointTrajectoryChunk, rows: slice, layout: _PointLayout) -> bytes:
    time = chunk.time_from_start[rows]
    points = np.zeros(len(time), layout.record)
    for field in FIELDS:
        array = getattr(chunk, field)
        if array is not None and array.shape[1]:
            points[f"{field}_size"] = array.shape[1]
            points[field] = array[rows]
    points["sec"], points["nanosec"] = np.divmod(time, NANOSECONDS)
    return points.tobytes()


def serialise_joint_trajectory(chunk: JointTrajectoryChunk) -> bytes:
    """Serialise a trajectory, byte for byte as ROS 2 does.

    Args:
        chunk: The points.

    Returns:
        The message in little-endian CDR 1.
    """
    builder = CdrBuilder()
    sec, nanosec = divmod(chunk.stamp_ns, NANOSECONDS)
    builder.data.extend(np.array([sec], "<i4").tobytes() + np.array([nanosec], "<u4").tobytes())
    builder.string(chunk.frame_id)
    builder.strings(chunk.names)
    n_points = len(chunk.time_from_start)
    builder.uint32(n_points)
    if not n_points:
        return bytes(builder.data)
    sizes = tuple(0 if getattr(chunk, field) is None else len(chunk.names) for field in FIELDS)
    # all points but the first begin at the same remainder modulo 8, so two record layouts are enough
    first = _point_layout((len(builder.data) - 4) % 8, sizes)
    others = _point_layout(first.next_offset, sizes)
    return b"".join((builder.data, _points(chunk, slice(0, 1), first), _points(chunk, slice(1, None), others)))


def _first_sizes(cursor: CdrCursor, n_names: int) -> tuple[int, ...]:
    start = cursor.position
    sizes = tuple(cursor.doubles(f"points[0].{field}")[1] for field in FIELDS)
    cursor.position = start
    for field, size in zip(FIELDS, sizes, strict=True):
        if size not in (0, n_names):
            raise MessageError(f"a JointTrajectory has {n_names} joint names but {size} values in points[0].{field}")
    return sizes


def _records(cursor: CdrCursor, n: int, layout: _PointLayout, sizes: Sequence[int]) -> NDArray[np.void]:
    start = cursor.skip(n * layout.record.itemsize, f"{n} points that fill the same fields")
    points: NDArray[np.void] = np.frombuffer(cursor.payload, layout.record, n, start)
    for field, size in zip(FIELDS, sizes, strict=True):
        if np.any(points[f"{field}_size"] != size):
            raise MessageError(
                "the points of a JointTrajectory differ in the fields that they fill; fill a field in all or in none"
            )
    return points


def read_joint_trajectory(payload: bytes | memoryview) -> JointTrajectoryChunk:
    """Decode a trajectory of any ROS 2 sender.

    Args:
        payload: Serialised message.

    Returns:
        Its points.

    Raises:
        MessageError: The bytes are not a JointTrajectory, or its points differ in the fields that they fill.
    """
    cursor = CdrCursor(payload)
    cursor.skip(8, "header.stamp")
    sec, nanosec = np.frombuffer(payload, f"{cursor.order}i4, {cursor.order}u4", 1, STAMP_OFFSET)[0].tolist()
    stamp = sec * NANOSECONDS + nanosec
    frame_id = cursor.string("header.frame_id")
    names = cursor.strings("joint_names")
    n_points = cursor.uint32("points")
    if not n_points:
        return JointTrajectoryChunk(stamp, names, np.empty(0, np.int64), frame_id=frame_id)
    sizes = _first_sizes(cursor, len(names))
    first = _point_layout((cursor.position - 4) % 8, sizes, cursor.order, cursor.widest)
    others = _point_layout(first.next_offset, sizes, cursor.order, cursor.widest)
    parts = (_records(cursor, 1, first, sizes), _records(cursor, n_points - 1, others, sizes))

    time = np.concatenate([part["sec"].astype(np.int64) * NANOSECONDS + part["nanosec"] for part in parts])

    def values(field: str) -> FloatArray | None:
        filled = sizes[FIELDS.index(field)]
        return np.concatenate([part[field].astype(np.float64) for part in parts]) if filled else None

    return JointTrajectoryChunk(
        stamp,
        names,
        time,
        positions=values("positions"),
        velocities=values("velocities"),
        accelerations=values("accelerations"),
        effort=values("effort"),
        frame_id=frame_id,
    )


@final
class JointTrajectoryCodec(AbstractCodec[JointTrajectoryChunk]):
    """trajectory_msgs/msg/JointTrajectory: points of a reference, sent ahead of time."""

    type: ClassVar[str] = "trajectory_msgs/msg/JointTrajectory"
    sampled: ClassVar[bool] = False

    def read(self, payload: bytes | memoryview) -> JointTrajectoryChunk:
        """Return the points of a message."""
        return read_joint_trajectory(payload)
