"""Time series of a log: joints, poses, and the log that holds them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    import plotly.graph_objects as go
    import xarray

    from flexros.arrays import FloatArray, IntArray

BASE_FRAME = "base"
"""Frame in which tool poses are given (the contract of the topics)."""


def _check_shape(owner: str, name: str, array: FloatArray | None, shape: tuple[int, int]) -> None:
    if array is not None and (array.shape != shape or array.dtype != np.float64):
        raise InputError(
            f"{owner}.{name} has shape {array.shape} and type {array.dtype}, allowed is {shape} and float64; "
            "give one row per stamp"
        )


def _check_stamp(owner: str, stamp: IntArray) -> None:
    if stamp.ndim != 1 or stamp.dtype != np.int64:
        raise InputError(
            f"{owner}.stamp has shape {stamp.shape} and type {stamp.dtype}, allowed is (n,) and int64; "
            "give nanoseconds as integers"
        )
    if np.any(stamp[1:] <= stamp[:-1]):
        at = int(np.argmax(stamp[1:] <= stamp[:-1])) + 1
        raise InputError(f"{owner}.stamp does not increase at row {at}; sort it and drop repeats")


def _check_received(owner: str, received: IntArray | None, n: int) -> None:
    if received is not None and (received.shape != (n,) or received.dtype != np.int64):
        raise InputError(
            f"{owner}.received has shape {received.shape} and type {received.dtype}, allowed is ({n},) and int64; "
            "give nanoseconds as integers, one per stamp"
        )


class Series(Protocol):
    """Time series of any topic."""

    @property
    def stamp(self) -> IntArray:
        """Sampling instants [ns], increasing, shape (n,)."""

    @property
    def received(self) -> IntArray | None:
        """Log time of each message [ns], shape (n,); None if it equals the stamp."""


@dataclass(frozen=True, eq=False)
class JointSeries:
    """Joint quantities over time; each is None where it was not recorded.

    Attributes:
        stamp: Sampling instants [ns], increasing, shape (n,).
        names: Joint names, length n_joints.
        position: Positions [rad or m], shape (n, n_joints).
        velocity: Velocities [rad/s or m/s], shape (n, n_joints).
        effort: Torques or forces [Nm or N], shape (n, n_joints).
        received: When the recorder took each message, its log time [ns], shape (n,); None if it equals the stamp.
    """

    stamp: IntArray
    names: tuple[str, ...]
    position: FloatArray | None = None
    velocity: FloatArray | None = None
    effort: FloatArray | None = None
    received: IntArray | None = None

    def __post_init__(self) -> None:
        _check_stamp("JointSeries", self.stamp)
        _check_received("JointSeries", self.received, len(self.stamp))
        if len(set(self.names)) != len(self.names):
            raise InputError(f"JointSeries.names has a name twice in {self.names}; give each joint a name of its own")
        for name in ("position", "velocity", "effort"):
            _check_shape("JointSeries", name, getattr(self, name), (len(self.stamp), len(self.names)))

    def until(self, stamp: int) -> JointSeries:
        """Return the part up to a stamp [ns], without copies."""
        n = int(np.searchsorted(self.stamp, stamp, side="right"))
        position, velocity, effort = (
            None if values is None else values[:n] for values in (self.position, self.velocity, self.effort)
        )
        received = None if self.received is None else self.received[:n]
        return JointSeries(self.stamp[:n], self.names, position, velocity, effort, received)


@dataclass(frozen=True, eq=False)
class PoseSeries:
    """Poses of one frame over time.

    Attributes:
        stamp: Sampling instants [ns], increasing, shape (n,).
        frame_id: Frame in which the poses are given.
        position: Positions [m], shape (n, 3).
        orientation: Quaternions x, y, z, w [-], shape (n, 4).
        received: When the recorder took each message, its log time [ns], shape (n,); None if it equals the stamp.
    """

    stamp: IntArray
    frame_id: str
    position: FloatArray
    orientation: FloatArray
    received: IntArray | None = None

    def __post_init__(self) -> None:
        _check_stamp("PoseSeries", self.stamp)
        _check_received("PoseSeries", self.received, len(self.stamp))
        _check_shape("PoseSeries", "position", self.position, (len(self.stamp), 3))
        _check_shape("PoseSeries", "orientation", self.orientation, (len(self.stamp), 4))


@dataclass(frozen=True, eq=False)
class ImuSeries:
    """Measurement of an accelerometer and a gyroscope over time.

    Attributes:
        stamp: Sampling instants [ns], increasing, shape (n,).
        frame_id: Frame of the sensor.
        acceleration: Acceleration with gravity [m/s^2], NaN along axes that were not measured, shape (n, 3); None where
            it was not measured.
        turning_rate: Turning rate [rad/s], as above, shape (n, 3).
        received: When the recorder took each message, its log time [ns], shape (n,); None if it equals the stamp.
    """

    stamp: IntArray
    frame_id: str
    acceleration: FloatArray | None = None
    turning_rate: FloatArray | None = None
    received: IntArray | None = None

    def __post_init__(self) -> None:
        _check_stamp("ImuSeries", self.stamp)
        _check_received("ImuSeries", self.received, len(self.stamp))
        _check_shape("ImuSeries", "acceleration", self.acceleration, (len(self.stamp), 3))
        _check_shape("ImuSeries", "turning_rate", self.turning_rate, (len(self.stamp), 3))


@dataclass(frozen=True, eq=False, repr=False)
class Log:
    """One recorded run: the time series of its topics and their provenance.

    Attributes:
        joint_states: Measurement of the motors.
        joint_commands: Torque commands; None if not recorded, as all series below.
        joint_reference: Reference that the controller used.
        tool_pose: True or measured tool pose.
        tool_reference: Commanded tool pose.
        provenance: Scenario, seed, versions and model hash, as written in the folder of the log.
        warnings: What the reader left out or repaired, one sentence each.
        other_topics: Number of messages of every topic that was not decoded, by name.
        plant_figures: Values that the plant node reported on /diagnostics, by key; the last message counts.
        other_series: Time series of further recorded topics of `topics.yaml`, by name.
    """

    joint_states: JointSeries
    joint_commands: JointSeries | None = None
    joint_reference: JointSeries | None = None
    tool_pose: PoseSeries | None = None
    tool_reference: PoseSeries | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    other_topics: Mapping[str, int] = field(default_factory=dict)
    plant_figures: Mapping[str, float] = field(default_factory=dict)
    other_series: Mapping[str, Series] = field(default_factory=dict)

    def series(self, topic: str) -> Series | None:
        """Return the time series of a topic by its relative name, None if not recorded."""
        series: Series | None = getattr(self, topic, None) if topic in OWN_SERIES else self.other_series.get(topic)
        return series

    def to_xarray(self, topic: str = "") -> xarray.Dataset:
        """Return time series as labelled arrays over `time` [s] since the first measurement.

        Args:
            topic: Relative name of a topic, e.g. "joint_states"; empty for all, with the topic before each name.

        Raises:
            InputError: The topic was not recorded.
        """
        from flexros.logs.labelled import dataset_of

        return dataset_of(self, topic)

    def to_pandas(self, topic: str = "") -> pd.DataFrame:
        """Return time series as a table over time [s], with columns such as "joint_states.position.motor_1".

        Args:
            topic: Relative name of a topic, then left out of the names of the columns; empty for all.

        Raises:
            InputError: The topic was not recorded.
        """
        from flexros.logs.labelled import frame_of

        return frame_of(self, topic)

    def plot(self) -> go.Figure:
        """Draw motor positions with their references, torques and tracking errors over time."""
        from flexros.logs.labelled import log_figure

        return log_figure(self)

    def __repr__(self) -> str:
        stamp = self.joint_states.stamp
        length = (stamp[-1] - stamp[0]) * 1e-9 if len(stamp) else 0.0
        return f"<Log: {len(self.joint_states.names)} motors, {len(stamp)} samples, {length:.6g} s>"

    def _repr_html_(self) -> str:
        from flexros.logs.labelled import log_html

        return log_html(self)


OWN_SERIES = ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference")
"""Topics that are fields of `Log`."""
