"""geometry_msgs/msg/PoseStamped as bytes: filled and read without building a message object."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexros.logs.messages.cdr_cursor import CdrBuilder, CdrCursor
from flexros.logs.messages.layout import MessageLayout, Span
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterable

TYPE = "geometry_msgs/msg/PoseStamped"

_N_POSE = 7


class PoseStampedLayout(NamedTuple):
    """Layout of PoseStamped messages of one frame.

    Attributes:
        message: Offsets; its one span is x, y, z, qx, qy, qz, qw.
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
    start = len(builder.data)
    builder.data.extend(bytes(8 * _N_POSE))
    return PoseStampedLayout(
        MessageLayout(bytes(builder.data), (Span(start, _N_POSE),), tuple(builder.padding)), frame_id
    )


def read_pose_stamped_layout(payload: bytes | memoryview) -> PoseStampedLayout:
    """Find the layout of a message from any sender.

    Args:
        payload: Serialised message.

    Returns:
        Its layout.

    Raises:
        MessageError: The bytes are not a PoseStamped.
    """
    cursor = CdrCursor(payload)
    cursor.skip(8, "header.stamp")
    frame_id = cursor.string("header.frame_id")
    cursor.align(8)
    span = Span(cursor.skip(8 * _N_POSE, "pose"), _N_POSE)
    return PoseStampedLayout(
        MessageLayout(bytes(payload[: cursor.position]), (span,), tuple(cursor.padding), cursor.order), frame_id
    )


class PoseStampedTemplate:
    """A serialised PoseStamped whose stamp and pose are filled in: the hot path of the nodes.

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
            The message, equal to what ROS 2 serialises.

        Raises:
            ValueError: There are not seven numbers.
        """
        sec, nanosec = divmod(stamp_ns, NANOSECONDS)
        start, before_pose = self._constants
        if isinstance(position, np.ndarray):
            position = position.tolist()
        if isinstance(orientation, np.ndarray):
            orientation = orientation.tolist()
        try:
            return self._pack(start, sec, nanosec, before_pose, *position, *orientation)
        except struct.error as error:
            raise ValueError(
                f"a PoseStamped cannot hold the stamp {stamp_ns}, position {position}, "
                f"orientation {orientation}: {error}"
            ) from error
