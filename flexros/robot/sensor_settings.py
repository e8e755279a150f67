"""The sensors of a robot file: noise, bias, delay, rate and mounting, each with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from flexros.config.settings import Settings
from flexros.robot.quantity import (
    Acceleration,
    Angles,
    AnyUnit,
    Hertz,
    Length,
    NotNegative,
    Position,
    Positive,
    Quantity,
    Seconds,
    TurningRate,
    Vector,
    check_unit,
    unit_of,
)
from flexros.robot.sparse_settings import SparseSettings

SensorAxis = Literal["x", "y", "z"]
AXES: tuple[SensorAxis, ...] = ("x", "y", "z")


def _nothing(unit: str) -> Quantity:
    return Quantity(value=0.0, unit=unit)


def _no_vector() -> Vector:
    return Vector(value=(0.0, 0.0, 0.0))


class LinkChannel(Settings):
    """Errors of one quantity that is measured at joints."""

    noise: NotNegative = Field(default_factory=lambda: _nothing(""), description="white, rms [rad, m, Nm or N]")
    bias: AnyUnit = Field(default_factory=lambda: _nothing(""), description="constant offset [rad, m, Nm or N]")

    def check_units(self, unit: str, key: str) -> None:
        """Refuse units that do not fit a joint; see `check_unit`."""
        check_unit(self.noise, unit, f"{key}.noise")
        check_unit(self.bias, unit, f"{key}.bias")


class LinkSensors(Settings):
    """Sensors behind the gears, sent on the topic link_states: encoders of the links and joint torque sensors."""

    joints: tuple[str, ...] = Field((), description="names of the motors whose joints have them; default: all")
    position: LinkChannel | None = Field(None, description="link-side encoder; default: there is none")
    torque: LinkChannel | None = Field(None, description="joint torque sensor; default: there is none")
    delay: Seconds = Field(
        default_factory=lambda: _nothing("s"), description="age of a value when it is sent, whole samples [s]"
    )
    rate: Hertz | None = Field(None, description="values per second [Hz], whole samples apart; default: every sample")

    @model_validator(mode="after")
    def _measures_something(self) -> LinkSensors:
        if self.position is None and self.torque is None:
            raise ValueError("needs 'position' (link-side encoder) or 'torque' (joint torque sensor), or both")
        return self

    def check_joints(self, rotary: tuple[bool, ...], key: str) -> None:
        """Refuse unknown joints, and units that do not fit them.

        Args:
            rotary: Whether each motor turns, shape (M,).
            key: Its key in the robot file.

        Raises:
            ValueError: Names key and joint.
        """
        known = tuple(f"motor_{number + 1}" for number in range(len(rotary)))
        for name in self.joints:
            if name not in known:
                raise ValueError(f"{key}.joints names '{name}', but the motors are {', '.join(known)}")
        if len(set(self.joints)) != len(self.joints):
            raise ValueError(f"{key}.joints names a joint twice in {', '.join(self.joints)}; name each once")
        for name in self.joints or known:
            turns = rotary[known.index(name)]
            if self.position is not None:
                self.position.check_units(unit_of("position", turns), f"{key}.position")
            if self.torque is not None:
                self.torque.check_units(unit_of("torque", turns), f"{key}.torque")


class Accelerometer(Settings):
    """Errors and axes of the accelerometer of the tool."""

    noise: NotNegative = Field(default_factory=lambda: _nothing("m/s2"), description="white, rms [m/s2]")
    bias: Acceleration = Field(default_factory=_no_vector, description="constant offset along x, y, z [m/s2]")
    axes: tuple[SensorAxis, ...] = Field(AXES, min_length=1, description="measured axes of the sensor")

    @model_validator(mode="after")
    def _units(self) -> Accelerometer:
        check_unit(self.noise, "m/s2", "noise")
        return self


class Gyroscope(Settings):
    """Errors and axes of the gyroscope of the tool."""

    noise: NotNegative = Field(default_factory=lambda: _nothing("rad/s"), description="white, rms [rad/s]")
    bias: TurningRate = Field(default_factory=_no_vector, description="constant offset about x, y, z [rad/s]")
    axes: tuple[SensorAxis, ...] = Field(AXES, min_length=1, description="measured axes of the sensor")

    @model_validator(mode="after")
    def _units(self) -> Gyroscope:
        check_unit(self.noise, "rad/s", "noise")
        return self


class ToolImu(Settings):
    """Accelerometer and gyroscope of the tool, sent on the topic tool_imu."""

    acceleration: Accelerometer | None = Field(None, description="accelerometer; default: there is none")
    turning_rate: Gyroscope | None = Field(None, description="gyroscope; default: there is none")
    position: Position = Field(default_factory=_no_vector, description="place in the frame of the tool [m]")
    orientation: Angles = Field(
        default_factory=_no_vector, description="roll, pitch, yaw of the sensor in the frame of the tool [rad]"
    )
    delay: Seconds = Field(
        default_factory=lambda: _nothing("s"), description="age of a value when it is sent, whole samples [s]"
    )
    rate: Hertz | None = Field(None, description="values per second [Hz], whole samples apart; default: every sample")

    @model_validator(mode="after")
    def _measures_something(self) -> ToolImu:
        if self.acceleration is None and self.turning_rate is None:
            raise ValueError("needs 'acceleration' (accelerometer) or 'turning_rate' (gyroscope), or both")
        for channel in (self.acceleration, self.turning_rate):
            if channel is not None and list(channel.axes) != [axis for axis in AXES if axis in channel.axes]:
                raise ValueError(f"axes are {', '.join(channel.axes)}, but must be each of x, y, z once, in this order")
        return self


class Sensors(SparseSettings):
    """Sensors of the robot."""

    absent: ClassVar[Mapping[str, Any]] = MappingProxyType({"link": None, "tool_imu": None})

    encoder_noise: NotNegative = Field(
        default_factory=lambda: _nothing(""), description="white, rms [rad, or m] in the coordinate"
    )
    tool_noise: Length = Field(
        default_factory=lambda: Quantity(value=20e-6, unit="m"), description="tracker, white, rms [m]"
    )
    link: LinkSensors | None = Field(None, description="link-side encoders and joint torque sensors; default: none")
    tool_imu: ToolImu | None = Field(None, description="accelerometer and gyroscope of the tool; default: none")
    link_encoder_noise: Positive | None = Field(
        None, description="of recorded link-side encoders, or strain gauges, rms [rad, or m]; default: as the log shows"
    )
    joint_torque_noise: Positive | None = Field(
        None, description="of recorded joint torque sensors, rms [Nm, or N]; default: as the log shows"
    )
    accelerometer_noise: Positive | None = Field(
        None, description="of a recorded accelerometer of the tool, rms [m/s2]; default: as the log shows"
    )
    gyroscope_noise: Positive | None = Field(
        None, description="of a recorded gyroscope of the tool, rms [rad/s]; default: as the log shows"
    )
