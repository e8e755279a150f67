"""sensor_msgs/msg/Imu: acceleration and turning rate, read from bytes and written without a message object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, final

import numpy as np

from flexros.logs.cdr_cursor import CdrBuilder, CdrCursor
from flexros.logs.messages.codec import AbstractSeriesCodec
from flexros.logs.messages.layout import MessageLayout, Span
from flexros.logs.messages.series_assembly import majority, sorted_rows
from flexros.logs.stamps import NANOSECONDS, stamp_of_message
from flexros.logs.time_series import ImuSeries

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.messages.bulk_decode import Segment

_N_IMU = 37
"""Numbers of a message: quaternion, turning rate and acceleration, each with the nine entries of its covariance."""

_ORIENTATION, _RATE, _ACCELERATION = 0, 13, 25
"""First number of each of the three."""

_UNKNOWN = -1.0
"""First entry of a covariance whose quantity is not measured (sensor_msgs)."""


class ImuLayout(NamedTuple):
    """Layout of Imu messages of one frame.

    Attributes:
        message: Offsets; its one span is all numbers.
        frame_id: header.frame_id.
    """

    message: MessageLayout
    frame_id: str


def imu_layout(frame_id: str) -> ImuLayout:
    """Lay out a message in little-endian CDR 1, byte for byte as ROS 2 does."""
    builder = CdrBuilder()
    builder.data.extend(bytes(8))
    builder.string(frame_id)
    builder.align(8)
    start = len(builder.data)
    builder.data.extend(bytes(8 * _N_IMU))
    return ImuLayout(MessageLayout(bytes(builder.data), (Span(start, _N_IMU),), tuple(builder.padding)), frame_id)


def read_imu_layout(payload: bytes | memoryview) -> ImuLayout:
    """Return the layout of a message of any sender.

    Raises:
        MessageError: The bytes are not an Imu.
    """
    cursor = CdrCursor(payload)
    cursor.skip(8, "header.stamp")
    frame_id = cursor.string("header.frame_id")
    cursor.align(8)
    span = Span(cursor.skip(8 * _N_IMU, "orientation, angular_velocity and linear_acceleration"), _N_IMU)
    return ImuLayout(
        MessageLayout(bytes(payload[: cursor.position]), (span,), tuple(cursor.padding), cursor.order), frame_id
    )


class ImuSample(NamedTuple):
    """One decoded message; a quantity is None where its covariance marks it as not measured.

    Attributes:
        stamp_ns: header.stamp [ns].
        acceleration: Acceleration with gravity along x, y, z [m/s^2], NaN along axes that are not measured.
        turning_rate: Turning rate about x, y, z [rad/s], likewise.
    """

    stamp_ns: int
    acceleration: tuple[float, ...] | None
    turning_rate: tuple[float, ...] | None


class ImuTemplate:
    """A serialised Imu in which stamp and numbers are set: the hot path of the nodes.

    Args:
        frame_id: header.frame_id.
        acceleration: Whether the messages have accelerations.
        turning_rate: Whether they have turning rates.
    """

    def __init__(self, frame_id: str, *, acceleration: bool = False, turning_rate: bool = False) -> None:
        layout = imu_layout(frame_id).message
        self._pack, (self._start, self._before) = layout.packer.pack, layout.constants
        self._numbers = [0.0] * _N_IMU
        for present, first in ((False, _ORIENTATION + 1), (turning_rate, _RATE), (acceleration, _ACCELERATION)):
            if not present:
                self._numbers[first + 3] = _UNKNOWN

    def fill(self, stamp_ns: int, acceleration: Sequence[float] = (), turning_rate: Sequence[float] = ()) -> bytes:
        """Serialise one message.

        Args:
            stamp_ns: header.stamp [ns].
            acceleration: Along x, y, z [m/s^2]; empty if the template has none.
            turning_rate: About x, y, z [rad/s], likewise.

        Returns:
            The message, byte for byte as ROS 2 serialises it.
        """
        sec, nanosec = divmod(stamp_ns, NANOSECONDS)
        for values, first in ((turning_rate, _RATE), (acceleration, _ACCELERATION)):
            if len(values):
                self._numbers[first : first + 3] = values
        return self._pack(self._start, sec, nanosec, self._before, *self._numbers)


class ImuView:
    """Parser of Imu messages of any sender; the layout of the last message is cached."""

    def __init__(self) -> None:
        self._learn(imu_layout(""))

    def _learn(self, layout: ImuLayout) -> None:
        self._unpack, self._known, self._pick, self._stamp, (self._numbers,) = layout.message.unpacking

    def unpack(self, payload: bytes | memoryview) -> ImuSample:
        """Decode a message.

        Raises:
            MessageError: The bytes are not an Imu.
        """
        values = self._unpack.unpack_from(payload) if len(payload) >= self._unpack.size else None
        if values is None or self._pick(values) != self._known:
            self._learn(read_imu_layout(payload))
            values = self._unpack.unpack_from(payload)
        numbers = values[self._numbers]
        rate, acceleration = (
            None if numbers[first + 3] == _UNKNOWN else numbers[first : first + 3] for first in (_RATE, _ACCELERATION)
        )
        return ImuSample(values[self._stamp] * NANOSECONDS + values[self._stamp + 1], acceleration, rate)


@final
class ImuCodec(AbstractSeriesCodec[ImuLayout]):
    """sensor_msgs/msg/Imu: acceleration and turning rate in the frame of the sensor; its orientation is not used."""

    type: ClassVar[str] = "sensor_msgs/msg/Imu"
    sampled: ClassVar[bool] = True

    def read(self, payload: bytes | memoryview) -> ImuLayout:
        """Return the layout of a message."""
        return read_imu_layout(payload)

    def assemble(self, topic: str, segments: Sequence[Segment[ImuLayout]], warnings: list[str]) -> ImuSeries:
        """Make a time series of the messages in the most frequent frame."""
        segments = majority(topic, segments, lambda layout: layout.frame_id, "frames", warnings)
        rows = sorted_rows(topic, segments, [segment.numbers for segment in segments], warnings)
        (numbers,) = rows.columns
        rate, acceleration = (_measured(numbers, first) for first in (_RATE, _ACCELERATION))
        return ImuSeries(rows.stamp, segments[0].layout.frame_id, acceleration, rate, rows.received)

    def columns(self, series: ImuSeries) -> tuple[MessageLayout, list[FloatArray]]:
        """Return the layout, and the numbers with the marks of what was not measured."""
        numbers = np.zeros((len(series.stamp), _N_IMU))
        numbers[:, _ORIENTATION + 4] = _UNKNOWN
        for first, values in ((_RATE, series.turning_rate), (_ACCELERATION, series.acceleration)):
            if values is None:
                numbers[:, first + 3] = _UNKNOWN
            else:
                numbers[:, first : first + 3] = values
        return imu_layout(series.frame_id).message, [numbers]

    def serialiser(self) -> Callable[[Any], bytes]:
        """Return a function that serialises a message object."""

        def serialise(message: Any) -> bytes:
            o, w, a = message.orientation, message.angular_velocity, message.linear_acceleration
            numbers = [
                *(o.x, o.y, o.z, o.w, *message.orientation_covariance),
                *(w.x, w.y, w.z, *message.angular_velocity_covariance),
                *(a.x, a.y, a.z, *message.linear_acceleration_covariance),
            ]
            layout = imu_layout(message.header.frame_id).message
            stamp = np.array([stamp_of_message(message)], np.int64)
            return bytes(layout.serialise(stamp, [np.array([numbers], dtype=np.float64)])[0].tobytes())

        return serialise


def _measured(numbers: FloatArray, first: int) -> FloatArray | None:
    """Return three numbers of every message; None where no message has measured them."""
    if np.all(numbers[:, first + 3] == _UNKNOWN):
        return None
    return numbers[:, first : first + 3].copy()
