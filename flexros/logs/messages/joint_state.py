"""sensor_msgs/msg/JointState: serialised and parsed without a message object."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, final

import numpy as np

from flexros.logs.cdr_cursor import CdrBuilder, CdrCursor, MessageError
from flexros.logs.messages.codec import AbstractSeriesCodec
from flexros.logs.messages.layout import MessageLayout, Span
from flexros.logs.messages.series_assembly import majority, sorted_rows, warn_of_not_finite
from flexros.logs.stamps import NANOSECONDS, stamp_of_message
from flexros.logs.time_series import JointSeries

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.messages.bulk_decode import Segment

FIELDS = ("position", "velocity", "effort")


class JointStateLayout(NamedTuple):
    """Layout of JointState messages with the same names, frame and filled fields.

    Attributes:
        message: Offsets; its three spans are position, velocity and effort, of count 0 where empty.
        names: Joint names in the order of the message.
        frame_id: header.frame_id.
    """

    message: MessageLayout
    names: tuple[str, ...]
    frame_id: str


class JointStateSample(NamedTuple):
    """One decoded message; a field is None where the message leaves it empty.

    Attributes:
        stamp_ns: header.stamp [ns].
        position: Positions [rad or m], one per joint.
        velocity: Velocities [rad/s or m/s], one per joint.
        effort: Torques or forces [Nm or N], one per joint.
    """

    stamp_ns: int
    position: tuple[float, ...] | None
    velocity: tuple[float, ...] | None
    effort: tuple[float, ...] | None


def joint_state_layout(names: Sequence[str], filled: Iterable[str], frame_id: str = "") -> JointStateLayout:
    """Lay out a message in little-endian CDR 1, byte for byte as ROS 2 does.

    Args:
        names: Joint names.
        filled: Fields that are not empty, of position, velocity and effort.
        frame_id: header.frame_id.

    Returns:
        The layout.
    """
    filled = set(filled)
    if unknown := filled - set(FIELDS):
        raise ValueError(f"JointState has no field {sorted(unknown)}, only {FIELDS}")
    builder = CdrBuilder()
    builder.data.extend(bytes(8))
    builder.string(frame_id)
    builder.strings(tuple(names))
    counts = [len(names) if field in filled else 0 for field in FIELDS]
    spans = tuple(Span(builder.doubles(count), count) for count in counts)
    return JointStateLayout(MessageLayout(bytes(builder.data), spans, tuple(builder.padding)), tuple(names), frame_id)


def read_joint_state_layout(payload: bytes | memoryview) -> JointStateLayout:
    """Return the layout of a message of any sender.

    Raises:
        MessageError: The bytes are not a JointState, or a field has another length than the names.
    """
    cursor = CdrCursor(payload)
    cursor.skip(8, "header.stamp")
    frame_id = cursor.string("header.frame_id")
    names = cursor.strings("name")
    spans = tuple(Span(*cursor.doubles(field)) for field in FIELDS)
    for field, span in zip(FIELDS, spans, strict=True):
        if span.size not in (0, len(names)):
            raise MessageError(f"a JointState has {len(names)} names but {span.size} values in {field}")
    return JointStateLayout(
        MessageLayout(bytes(payload[: cursor.position]), spans, tuple(cursor.padding), cursor.order), names, frame_id
    )


class JointStateTemplate:
    """A serialised JointState in which stamp and numbers are set: the hot path of the nodes.

    Args:
        names: Joint names.
        position: Whether the messages have positions.
        velocity: Whether they have velocities.
        effort: Whether they have efforts.
        frame_id: header.frame_id.
    """

    def __init__(
        self,
        names: Sequence[str],
        *,
        position: bool = False,
        velocity: bool = False,
        effort: bool = False,
        frame_id: str = "",
    ) -> None:
        present = (position, velocity, effort)
        self.filled = tuple(field for field, is_present in zip(FIELDS, present, strict=True) if is_present)
        self.layout = joint_state_layout(names, self.filled, frame_id)
        self._pack = self.layout.message.packer.pack
        self._constants = self.layout.message.constants

    def fill(
        self,
        stamp_ns: int,
        position: Iterable[float] = (),
        velocity: Iterable[float] = (),
        effort: Iterable[float] = (),
    ) -> bytes:
        """Serialise one message.

        Args:
            stamp_ns: header.stamp [ns].
            position: Positions [rad or m], one per joint; empty if the template has none.
            velocity: Velocities [rad/s or m/s], likewise.
            effort: Torques or forces [Nm or N], likewise.

        Returns:
            The message, byte for byte as ROS 2 serialises it.

        Raises:
            ValueError: A field has another length than the template.
        """
        sec, nanosec = divmod(stamp_ns, NANOSECONDS)
        start, before_position, before_velocity, before_effort = self._constants
        if isinstance(position, np.ndarray):  # unpacking an array element by element is four times slower
            position = position.tolist()
        if isinstance(velocity, np.ndarray):
            velocity = velocity.tolist()
        if isinstance(effort, np.ndarray):
            effort = effort.tolist()
        try:
            return self._pack(
                start, sec, nanosec, before_position, *position, before_velocity, *velocity, before_effort, *effort
            )
        except struct.error as error:
            raise ValueError(
                f"a JointState template of {len(self.layout.names)} joints with {self.filled} cannot hold the stamp "
                f"{stamp_ns}, position {position}, velocity {velocity}, effort {effort}: {error}"
            ) from error


class JointStateView:
    """Parser of JointState messages of one topic, with a fixed order of joints.

    The layout of the last message is cached: as long as the sender keeps names and filled fields, a message costs one
    unpacking and a comparison of the constant bytes.

    Args:
        names: Joint names in the required order; further joints in a message are ignored.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._learn(joint_state_layout(names, FIELDS))

    def _learn(self, layout: JointStateLayout) -> None:
        missing = [name for name in self.names if name not in layout.names]
        if missing:
            raise MessageError(
                f"a JointState lacks {', '.join(missing)}; it has {', '.join(layout.names) or 'no joints'}"
            )
        n = len(layout.names)
        order = tuple(layout.names.index(name) for name in self.names)
        self._order = None if order == tuple(range(n)) else order
        self._unpack, self._known, self._pick_constants, self._stamp, slices = layout.message.unpacking
        self._slices = [part if part.stop else None for part in slices]

    def _pick(self, values: tuple[Any, ...], part: slice | None) -> tuple[float, ...] | None:
        if part is None:
            return None
        span = values[part]
        return span if self._order is None else tuple([span[i] for i in self._order])

    def _values(self, payload: bytes | memoryview) -> tuple[Any, ...] | None:
        if len(payload) < self._unpack.size:
            return None
        values = self._unpack.unpack_from(payload)
        return values if self._pick_constants(values) == self._known else None

    def unpack(self, payload: bytes | memoryview) -> JointStateSample:
        """Decode a message.

        Args:
            payload: Serialised message of any ROS 2 sender.

        Returns:
            Stamp and values in the order of `names`.

        Raises:
            MessageError: The bytes are not a JointState or lack a joint.
        """
        values = self._values(payload)
        if values is None:
            self._learn(read_joint_state_layout(payload))
            values = self._unpack.unpack_from(payload)
        position, velocity, effort = self._slices
        return JointStateSample(
            values[self._stamp] * NANOSECONDS + values[self._stamp + 1],
            self._pick(values, position),
            self._pick(values, velocity),
            self._pick(values, effort),
        )


@final
class JointStateCodec(AbstractSeriesCodec[JointStateLayout]):
    """sensor_msgs/msg/JointState: positions, velocities and efforts of named joints."""

    type: ClassVar[str] = "sensor_msgs/msg/JointState"
    sampled: ClassVar[bool] = True

    def read(self, payload: bytes | memoryview) -> JointStateLayout:
        """Return the layout of a message."""
        return read_joint_state_layout(payload)

    def assemble(self, topic: str, segments: Sequence[Segment[JointStateLayout]], warnings: list[str]) -> JointSeries:
        """Make a time series with the joints in the order of the first message."""
        segments = majority(topic, segments, lambda layout: frozenset(layout.names), "joint names", warnings)
        names = min(segments, key=lambda segment: int(segment.order[0])).layout.names
        rows = sorted_rows(topic, segments, [_in_order(segment, names) for segment in segments], warnings)
        values: dict[str, FloatArray | None] = dict.fromkeys(FIELDS)
        for i, (field, column) in enumerate(zip(FIELDS, rows.columns, strict=True)):
            if any(segment.layout.message.spans[i].size for segment in segments):
                values[field] = column
                warn_of_not_finite(topic, field, (column,), warnings)
        return JointSeries(rows.stamp, names, received=rows.received, **values)

    def columns(self, series: JointSeries) -> tuple[MessageLayout, list[FloatArray]]:
        """Return layout and columns; a field that was not recorded has no columns."""
        values = [getattr(series, field) for field in FIELDS]
        filled = [field for field, array in zip(FIELDS, values, strict=True) if array is not None]
        empty = np.empty((len(series.stamp), 0))
        return joint_state_layout(series.names, filled).message, [empty if v is None else v for v in values]

    def serialiser(self) -> Callable[[Any], bytes]:
        """Return a function that serialises a message object; it keeps one template per set of names and fields."""
        templates: dict[tuple[object, ...], JointStateTemplate] = {}

        def serialise(message: Any) -> bytes:
            values = [[float(v) for v in getattr(message, field, ())] for field in FIELDS]
            key = (message.header.frame_id, tuple(message.name), *(bool(v) for v in values))
            if key not in templates:
                position, velocity, effort = (bool(v) for v in values)
                templates[key] = JointStateTemplate(
                    message.name, position=position, velocity=velocity, effort=effort, frame_id=message.header.frame_id
                )
            return templates[key].fill(stamp_of_message(message), *values)

        return serialise


def _in_order(segment: Segment[JointStateLayout], names: Sequence[str]) -> list[FloatArray]:
    """Return the columns in the order of `names`; NaN where the messages leave a field empty."""
    columns = [segment.layout.names.index(name) for name in names]
    empty = np.full((len(segment.stamp), len(names)), np.nan)
    if columns == list(range(len(names))):
        return [values if values.shape[1] else empty for values in segment.numbers]
    return [values[:, columns] if values.shape[1] else empty for values in segment.numbers]
