"""Time series of the further sensors of a run, as the plant node sends them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.logs.time_series import ImuSeries, JointSeries

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Series
    from flexros.robot import Robot
    from flexros.simulate.sensor_timing import SensorTiming

TOOL_FRAME = "tool"
"""Frame of the sensors at the tool."""

FIELDS = {
    "link_position": "position",
    "joint_torque": "effort",
    "tool_acceleration": "acceleration",
    "tool_turning_rate": "turning_rate",
}
"""Field of the time series of each measurement."""


def sensor_series(robot: Robot, timing: SensorTiming, values: FloatArray, stamp: IntArray) -> dict[str, Series]:
    """Return the series of `link_states` and `tool_imu`, one row per value that is sent.

    Args:
        robot: The simulated robot.
        timing: Delay and rate of its further sensors.
        values: Their values before delay and hold, shape (n, n_further).
        stamp: Stamps of all samples [ns], shape (n,).
    """
    found: dict[str, dict[str, Any]] = {}
    sent: dict[str, IntArray] = {}
    joints: dict[str, tuple[str, ...]] = {}
    held, begin = timing.held(values), 0
    for sensor in robot.further_sensors:
        rows = np.arange(0, len(values), timing.period[begin])
        columns = held[rows, begin : begin + sensor.size]
        begin += sensor.size
        sent[sensor.topic] = rows
        if sensor.of_tool:
            columns, channels = np.full((len(rows), 3), np.nan), columns
            columns[:, list(sensor.indices)] = channels
        else:
            joints[sensor.topic] = tuple(robot.joint_names[index] for index in sensor.indices)
        found.setdefault(sensor.topic, {})[FIELDS[sensor.measurement]] = columns
    return {
        topic: JointSeries(stamp[sent[topic]], joints[topic], **fields)
        if topic in joints
        else ImuSeries(stamp[sent[topic]], TOOL_FRAME, **fields)
        for topic, fields in found.items()
    }
