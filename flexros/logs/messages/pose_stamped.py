"""geometry_msgs/msg/PoseStamped: serialised and parsed without a message object."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, final

import numpy as np

from flexros.logs.cdr_cursor import CdrBuilder, CdrCursor
from flexros.logs.messages.codec import AbstractSeriesCodec
from flexros.logs.messages.layout import MessageLayout, Span
from flexros.logs.messages.series_assembly import majority, sorted_rows, warn_of_not_finite
from flexros.logs.stamps import NANOSECONDS, stamp_of_message
from flexros.logs.time_series import PoseSeries

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.messages.bulk_decode import Segment

_N_POSITION, _N_ORIENTATION = 3, 4
_POSE_SIZE = 8 * (_N_POSITION + _N_ORIENTATION)
"""Bytes of a pose."""


class PoseStampedLayout(NamedTuple):
    """Layout of PoseStamped messages of one frame.

    Attributes:
        message: Offsets; its spans are x, y, z and qx, qy, qz, qw.
        frame_id: header.frame_id.
    """

    message: MessageLayout
    frame_id: str


def pose_stamped_layout(frame_id: str) -> PoseStampedLayout:
    """Lay out a message in little-endian CDR 1, byte for byte as ROS 2 does."""
    builder = CdrBuilder()
    builder.data.extend(bytes(8))
    builder.string(frame_id)
    builder.align(8)
    spans = _spans(len(builder.data))
    builder.data.extend(bytes(_POSE_SIZE))
    return PoseStampedLayout(MessageLayout(bytes(builder.data), spans, tuple(builder.padding)), frame_id)


def _spans(start: int) -> tuple[Span, Span]:
    """Return position and orientation of a pose that begins at an offset."""
    return Span(start, _N_POSITION), Span(start + 8 * _N_POSITION, _N_ORIENTATION)


def read_pose_stamped_layout(payload: bytes | memoryview) -> PoseStampedLayout:
    """Return the layout of a message of any sender.

    Raises:
        MessageError: The bytes are not a PoseStamped.
    """
    cursor = CdrCursor(payload)
    cursor.skip(8, "header.stamp")
    frame_id = cursor.string("header.frame_id")
    cursor.align(8)
    spans = _spans(cursor.skip(_POSE_SIZE, "pose"))
    return PoseStampedLayout(
        MessageLayout(bytes(payload[: cursor.position]), spans, tuple(cursor.padding), cursor.order), frame_id
    )


class PoseStampedTemplate:
    """A serialised PoseStamped in which stamp and pose are set: the hot path of the nodes.

    Args:
        frame_id: Frame in which the poses are given.
    """

    def __init__(self, frame_id: str) -> None:
        self.layout = pose_stamped_layout(frame_id)
        self._pack = self.layout.message.packer.pack
        self._constants = self.layout.message.constants

    def fill(self, stamp_ns: int, position: Iterable[float], orientation: Iterable[float]) -> bytes:
        """Serialise one message.

        Args:
            stamp_ns: header.stamp [ns].
            position: Position [m], 3 numbers.
            orientation: Quaternion x, y, z, w [-], 4 numbers.

        Returns:
            The message, byte for byte as ROS 2 serialises it.

        Raises:
            ValueError: There are not seven numbers.
        """
        sec, nanosec = divmod(stamp_ns, NANOSECONDS)
        start, before_position, before_orientation = self._constants
        if isinstance(position, np.ndarray):
            position = position.tolist()
        if isinstance(orientation, np.ndarray):
            orientation = orientation.tolist()
        try:
            return self._pack(start, sec, nanosec, before_position, *position, before_orientation, *orientation)
        except struct.error as error:
            raise ValueError(
                f"a PoseStamped cannot hold the stamp {stamp_ns}, position {position}, "
                f"orientation {orientation}: {error}"
            ) from error


@final
class PoseStampedCodec(AbstractSeriesCodec[PoseStampedLayout]):
    """geometry_msgs/msg/PoseStamped: position and orientation of one frame."""

    type: ClassVar[str] = "geometry_msgs/msg/PoseStamped"
    sampled: ClassVar[bool] = True

    def read(self, payload: bytes | memoryview) -> PoseStampedLayout:
        """Return the layout of a message."""
        return read_pose_stamped_layout(payload)

    def assemble(self, topic: str, segments: Sequence[Segment[PoseStampedLayout]], warnings: list[str]) -> PoseSeries:
        """Make a time series of the poses in the most frequent frame."""
        segments = majority(topic, segments, lambda layout: layout.frame_id, "frames", warnings)
        rows = sorted_rows(topic, segments, [segment.numbers for segment in segments], warnings)
        position, orientation = rows.columns
        warn_of_not_finite(topic, "pose", rows.columns, warnings)
        return PoseSeries(rows.stamp, segments[0].layout.frame_id, position, orientation, rows.received)

    def columns(self, series: PoseSeries) -> tuple[MessageLayout, list[FloatArray]]:
        """Return the layout, positions and orientations."""
        return pose_stamped_layout(series.frame_id).message, [series.position, series.orientation]

    def serialiser(self) -> Callable[[Any], bytes]:
        """Return a function that serialises a message object; it keeps one template per frame."""
        templates: dict[str, PoseStampedTemplate] = {}

        def serialise(message: Any) -> bytes:
            frame_id = message.header.frame_id
            if frame_id not in templates:
                templates[frame_id] = PoseStampedTemplate(frame_id)
            p, o = message.pose.position, message.pose.orientation
            return templates[frame_id].fill(stamp_of_message(message), (p.x, p.y, p.z), (o.x, o.y, o.z, o.w))

        return serialise
