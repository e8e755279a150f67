"""Messages of the sensors beside the motor encoders, written by a plant and read by a controller.

A message is sent at every sample at which its sensor has a new value; a reader holds the last one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from flexros.errors import RunError
from flexros.logs.messages.imu import ImuTemplate, ImuView
from flexros.logs.messages.joint_state import JointStateTemplate, JointStateView
from flexros.logs.stamps import NANOSECONDS
from flexros.scenario.sensor_series import FIELDS, TOOL_FRAME

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.further_sensors import FurtherSensor
    from flexros.simulate.sensor_timing import SensorTiming


class TopicSensors(NamedTuple):
    """Sensors that share a topic.

    Attributes:
        topic: Name of the topic.
        joints: Names of their joints; empty at the tool.
        sensors: The sensors.
        begins: First channel of each sensor among all further measurements.
        period: Samples from one message to the next.
    """

    topic: str
    joints: tuple[str, ...]
    sensors: tuple[FurtherSensor, ...]
    begins: tuple[int, ...]
    period: int


def sensor_topics(robot: Robot, timing: SensorTiming) -> tuple[TopicSensors, ...]:
    """Return the topics of a robot's sensors beside the motor encoders.

    Args:
        robot: The robot.
        timing: Delay and rate of its further sensors.
    """
    begins = [0]
    for sensor in robot.further_sensors:
        begins.append(begins[-1] + sensor.size)
    found = []
    for topic in dict.fromkeys(sensor.topic for sensor in robot.further_sensors):
        own = [(sensor, begin) for sensor, begin in zip(robot.further_sensors, begins) if sensor.topic == topic]
        first, begin = own[0]
        joints = () if first.of_tool else tuple(robot.joint_names[index] for index in first.indices)
        sensors, starts = zip(*own, strict=True)
        found.append(TopicSensors(topic, joints, sensors, starts, timing.period[begin]))
    return tuple(found)


class SensorWriter:
    """Serialises the further measurements of a sample.

    Args:
        topics: Topics of the sensors.
    """

    def __init__(self, topics: Sequence[TopicSensors]) -> None:
        self._topics = tuple(topics)
        self._templates: dict[str, JointStateTemplate | ImuTemplate] = {}
        for topic in topics:
            filled = {FIELDS[sensor.measurement] for sensor in topic.sensors}
            self._templates[topic.topic] = (
                JointStateTemplate(topic.joints, position="position" in filled, effort="effort" in filled)
                if topic.joints
                else ImuTemplate(
                    TOOL_FRAME, acceleration="acceleration" in filled, turning_rate="turning_rate" in filled
                )
            )

    def fill(self, sample: int, stamp: int, values: FloatArray) -> dict[str, bytes]:
        """Return the messages of a sample by topic; none where a sensor has no new value.

        Args:
            sample: Sample k.
            stamp: Its stamp [ns].
            values: Further measurements as they are held, shape (n_further,).
        """
        messages = {}
        for topic in self._topics:
            if sample % topic.period:
                continue
            numbers: dict[str, list[float]] = {}
            for sensor, begin in zip(topic.sensors, topic.begins, strict=True):
                channels = values[begin : begin + sensor.size].tolist()
                if sensor.of_tool:
                    spread = [math.nan] * 3
                    for index, value in zip(sensor.indices, channels, strict=True):
                        spread[index] = value
                    channels = spread
                numbers[FIELDS[sensor.measurement]] = channels
            messages[topic.topic] = self._templates[topic.topic].fill(stamp, **numbers)
        return messages


class SensorReader:
    """Further measurements by stamp, read from the messages of any sender.

    Args:
        topics: Topics of the sensors.
        size: Number of further measurements.
    """

    def __init__(self, topics: Sequence[TopicSensors], size: int) -> None:
        self._topics = {topic.topic: topic for topic in topics}
        self._views = {topic.topic: JointStateView(topic.joints) if topic.joints else ImuView() for topic in topics}
        self._size = size
        self.begin()

    def begin(self) -> None:
        """Return to the state before the first message."""
        self._new: dict[str, dict[int, list[tuple[int, float]]]] = {name: {} for name in self._topics}
        self._held = [math.nan] * self._size
        self._used = -1

    def take(self, name: str, message: bytes) -> None:
        """Take a message of a topic.

        Raises:
            MessageError: The bytes are not a message of its type, or a joint is missing.
            RunError: A value is missing or not finite.
        """
        topic, found = self._topics[name], self._views[name].unpack(message)
        if found.stamp_ns <= self._used:
            return  # a repeated message
        channels: list[tuple[int, float]] = []
        for sensor, begin in zip(topic.sensors, topic.begins, strict=True):
            field = FIELDS[sensor.measurement]
            values: tuple[float, ...] | None = getattr(found, field)
            if values is not None and sensor.of_tool:
                values = tuple(values[index] for index in sensor.indices)
            if values is None or not math.isfinite(sum(values)):
                raise RunError(
                    f"a message on {name} at stamp {found.stamp_ns / NANOSECONDS:.4f} s is rejected: its {field} is "
                    f"{'empty' if values is None else list(values)}, required are finite numbers of the sensors in "
                    "the robot file"
                )
            channels += [(begin + place, value) for place, value in enumerate(values)]
        self._new[name][found.stamp_ns] = channels

    def values(self, sample: int, stamp: int) -> list[float] | None:
        """Return the further measurements held at a sample; None while a message of it is missing.

        Args:
            sample: Sample k.
            stamp: Its stamp [ns].
        """
        if not self._topics:
            return self._held.copy()
        due = [name for name, topic in self._topics.items() if sample % topic.period == 0]
        if any(stamp not in self._new[name] for name in due):
            return None
        for messages in self._new.values():
            for old in sorted(messages):
                if old <= stamp:  # of samples that were skipped in real time the newest counts
                    for channel, value in messages.pop(old):
                        self._held[channel] = value
        self._used = stamp
        return self._held.copy()
