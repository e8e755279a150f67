"""The sensors of a robot beside its motor encoders, as channels of the loop: behind the gears and at the tool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.robot.sensor_settings import AXES

if TYPE_CHECKING:
    from flexros.robot.quantity import Quantity
    from flexros.robot.specification import RobotSpecification


@dataclass(frozen=True)
class FurtherSensor:
    """One sensor with its channels, in the order in which the loop stacks them.

    Attributes:
        measurement: Name of its measurement in the loop, e.g. "link_position".
        quantity: Name of its quantity in `flexros.record.further_sensors.SENSOR_QUANTITIES`.
        topic: Topic on which it is sent.
        indices: Number of the motor, or of the axis, of each channel.
        noise: White noise, rms, in the SI unit of the quantity.
        bias: Constant offset of each channel.
        delay: Age of a value when it is sent [s].
        rate: Values per second [Hz]; None for one at every sample.
    """

    measurement: str
    quantity: str
    topic: str
    indices: tuple[int, ...]
    noise: float
    bias: tuple[float, ...]
    delay: float
    rate: float | None

    @property
    def size(self) -> int:
        """Number of channels."""
        return len(self.indices)

    @property
    def of_tool(self) -> bool:
        """Whether it measures along axes of the tool, instead of at joints."""
        return self.topic == "tool_imu"


@dataclass(frozen=True, eq=False)
class Mounting:
    """Place of the accelerometer and gyroscope in the frame of the tool.

    Attributes:
        position: Place [m], shape (3,).
        orientation: Roll, pitch, yaw about the fixed axes [rad], shape (3,).
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float] = (0.0, 0.0, 0.0)


def list_sensors(specification: RobotSpecification, n_motors: int) -> tuple[FurtherSensor, ...]:
    """Return the sensors that a robot file states beside the motor encoders.

    Args:
        specification: The robot file.
        n_motors: Number of motors, M.
    """
    return (*_at_joints(specification, n_motors), *_at_tool(specification))


def mounting(specification: RobotSpecification) -> Mounting:
    """Return the place of the sensors at the tool; the tool point where the file states none."""
    imu = specification.sensors.tool_imu
    return Mounting() if imu is None else Mounting(imu.position.value, imu.orientation.value)


def _at_joints(specification: RobotSpecification, n_motors: int) -> list[FurtherSensor]:
    link = specification.sensors.link
    if link is None:
        return []
    names = [f"motor_{number + 1}" for number in range(n_motors)]
    indices = tuple(number for number, name in enumerate(names) if name in (link.joints or names))
    found = []
    for measurement, quantity, channel in (
        ("link_position", "link position", link.position),
        ("joint_torque", "joint torque", link.torque),
    ):
        if channel is not None:
            bias = (channel.bias.value,) * len(indices)
            timing = link.delay.value, _rate(link.rate)
            sensor = FurtherSensor(measurement, quantity, "link_states", indices, channel.noise.value, bias, *timing)
            found.append(sensor)
    return found


def _at_tool(specification: RobotSpecification) -> list[FurtherSensor]:
    imu = specification.sensors.tool_imu
    if imu is None:
        return []
    found = []
    for measurement, quantity, channel in (
        ("tool_acceleration", "tool acceleration", imu.acceleration),
        ("tool_turning_rate", "tool turning rate", imu.turning_rate),
    ):
        if channel is not None:
            indices = tuple(AXES.index(axis) for axis in channel.axes)
            bias = tuple(channel.bias.value[index] for index in indices)
            timing = imu.delay.value, _rate(imu.rate)
            sensor = FurtherSensor(measurement, quantity, "tool_imu", indices, channel.noise.value, bias, *timing)
            found.append(sensor)
    return found


def _rate(rate: Quantity | None) -> float | None:
    return None if rate is None else rate.value
