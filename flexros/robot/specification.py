"""The robot file: bodies, springs, dampers, motors, tool, sensors, each value with unit, source and tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from flexros.config.settings import Settings
from flexros.robot.bending import Bending, checked_bending
from flexros.robot.point_inertia import point_inertia
from flexros.robot.quantity import (
    Acceleration,
    AnyUnit,
    Inertia,
    InertiaProduct,
    Mass,
    NotNegative,
    Position,
    Positive,
    Quantity,
    Ratio,
    RotaryFriction,
    Seconds,
    Vector,
    at_least_zero,
    check_unit,
    positive,
    unit_of,
)
from flexros.robot.sensor_settings import Sensors
from flexros.robot.sparse_settings import SparseSettings
from flexros.robot.spring import Spring

Axis = Literal["rx", "ry", "rz", "tx", "ty", "tz"]
BendingAxis = Literal["rx", "ry", "rz"]
PoseComponent = Literal["x", "y", "z", "rx", "ry", "rz"]


def _zero(unit: str) -> Quantity:
    return Quantity(value=0.0, unit=unit)


Orientation = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""

PositiveRatio = Annotated[Ratio, AfterValidator(positive)]
NotNegativeRatio = Annotated[Ratio, AfterValidator(at_least_zero)]


class Servo(SparseSettings):
    """Position loop of a drive: torque = stiffness e + damping (feedforward command' - q') + integral times that of e.

    The error e is the command less the position q. The torque is limited at the `torque_limit` of the motor. Gains have
    the unit of the torque on the side of the gear that the file uses, so a torque constant is part of them.
    """

    absent: ClassVar[Mapping[str, Any]] = MappingProxyType({"integral": 0.0, "known": False})

    stiffness: Positive = Field(description="torque per position error [Nm/rad, or N/m]")
    damping: NotNegative = Field(default_factory=lambda: _zero(""), description="torque per speed [Nm s/rad, or N s/m]")
    feedforward: NotNegativeRatio = Field(
        default_factory=lambda: Quantity(value=0.0, unit="1"),
        description="share of the rate of the command that the damping follows; 0: it brakes the motor alone",
    )
    integral: NotNegative = Field(
        default_factory=lambda: _zero(""),
        description="torque per integral of the position error [Nm/(rad s), or N/(m s)]",
    )
    known: bool = Field(
        False,
        description="whether the drive computes its torque by these gains, so that no errors of them are sought",
    )

    def check_units(self, rotary: bool, key: str) -> None:
        """Refuse units that do not fit a rotary or prismatic motor; see `check_unit`."""
        for field in ("stiffness", "damping", "integral"):
            check_unit(getattr(self, field), unit_of(field, rotary), f"{key}.{field}")


class Motor(SparseSettings):
    """Motor behind the gear of one direction, placed on the preceding body."""

    absent: ClassVar[Mapping[str, Any]] = MappingProxyType({"servo": None, "speed_limit": None})

    inertia: NotNegative = Field(default_factory=lambda: _zero(""), description="rotor inertia [kg m2, or kg]")
    gear_ratio: PositiveRatio = Field(
        default_factory=lambda: Quantity(value=1.0, unit="1"), description="motor turns per arm turn"
    )
    viscous_friction: NotNegative = Field(default_factory=lambda: _zero(""), description="[Nm s/rad, or N s/m]")
    torque_limit: Positive | None = Field(None, description="largest absolute torque [Nm, or N]; default: unlimited")
    speed_limit: Positive | None = Field(
        None, description="largest speed of the direction that it moves [rad/s, or m/s]; default: unlimited"
    )
    encoder_noise: NotNegative | None = Field(None, description="rms [rad, or m]; default: sensors.encoder_noise")
    servo: Servo | None = Field(None, description="position loop of the drive, for logs with position commands only")

    def check_units(self, rotary: bool, key: str) -> None:
        """Refuse units that do not fit a rotary or prismatic motor; see `check_unit`."""
        kinds = {
            "inertia": "inertia",
            "viscous_friction": "damping",
            "torque_limit": "torque",
            "speed_limit": "speed",
            "encoder_noise": "position",
        }
        for field, kind in kinds.items():
            quantity = getattr(self, field)
            if quantity is not None:
                check_unit(quantity, unit_of(kind, rotary), f"{key}.{field}")
        if self.servo is not None:
            self.servo.check_units(rotary, f"{key}.servo")


class Direction(SparseSettings):
    """One direction of motion of a body relative to the body before it."""

    absent: ClassVar[Mapping[str, Any]] = MappingProxyType({"zero": None})

    spring: Spring | Literal["rigid"] = Field(
        description="spring; 'rigid': a direction without motor is removed, a gear with motor is stiff"
    )
    damper: NotNegative = Field(default_factory=lambda: _zero(""), description="[Nm s/rad, or N s/m]")
    motor: Motor | None = None
    zero: AnyUnit | None = Field(
        None,
        description="added to the coordinate in the geometry: error of an encoder zero, or of the mounting [rad, or m]",
    )

    @model_validator(mode="before")
    @classmethod
    def _from_word(cls, data: Any) -> Any:
        return {"spring": "rigid"} if data == "rigid" else data

    @model_validator(mode="after")
    def _motor_is_connected(self) -> Direction:
        spring = self.spring
        loose = isinstance(spring, Spring) and spring.stiffness is not None and spring.stiffness.value == 0
        if self.motor and loose and self.damper.value == 0:
            raise ValueError(
                "has a motor, but neither spring nor damper connects it: the chain is disconnected; give a stiffness, "
                "or the word 'rigid'"
            )
        return self


class InertiaTensor(Settings):
    """Inertia tensor about the centre of mass [kg m2]; missing entries are zero."""

    xx: Inertia = Field(default_factory=lambda: _zero("kg m2"))
    yy: Inertia = Field(default_factory=lambda: _zero("kg m2"))
    zz: Inertia = Field(default_factory=lambda: _zero("kg m2"))
    xy: InertiaProduct = Field(default_factory=lambda: _zero("kg m2"))
    xz: InertiaProduct = Field(default_factory=lambda: _zero("kg m2"))
    yz: InertiaProduct = Field(default_factory=lambda: _zero("kg m2"))

    def matrix(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return the tensor as a matrix [kg m2], shape (3, 3)."""
        xx, yy, zz = self.xx.value, self.yy.value, self.zz.value
        xy, xz, yz = self.xy.value, self.xz.value, self.yz.value
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class Body(SparseSettings):
    """Rigid body, described in its own frame, at zero coordinates parallel to that before it, or turned from it."""

    absent: ClassVar[Mapping[str, Any]] = MappingProxyType({"bending": {}, "orientation": (0.0, 0.0, 0.0)})

    label: str = ""
    parent: str = Field("", description="the body before; optional, since the bodies are in the order of the chain")
    mass: Mass = Field(default_factory=lambda: _zero("kg"))
    center_of_mass: Position = Field(default_factory=lambda: Vector(value=(0, 0, 0)), description="[m]")
    inertia: InertiaTensor = Field(default_factory=InertiaTensor)
    length: Position = Field(default_factory=lambda: Vector(value=(0, 0, 0)), description="to the next body [m]")
    viscous_friction: RotaryFriction = Field(
        default_factory=lambda: _zero("Nm s/rad"), description="against the absolute rotation of the body [Nm s/rad]"
    )
    orientation: Orientation = Field(
        (0.0, 0.0, 0.0),
        description="fixed turn of its frame from that of the body before, for axes that are not along x, y or z: "
        "roll, pitch and yaw about fixed axes, as in a URDF [rad]",
    )
    directions: dict[Axis, Direction] = Field(default_factory=dict, description="in the order of the chain")
    bending: dict[BendingAxis, Bending] = Field(
        default_factory=dict, description="bending of the link about an axis across its length, as assumed modes"
    )

    @model_validator(mode="after")
    def _one_motor_and_units(self) -> Body:
        geared = [axis for axis, direction in self.directions.items() if direction.motor]
        if len(geared) > 1:
            raise ValueError(
                f"directions {', '.join(geared)} have motors, but a body has at most one actuated direction"
            )
        for axis, direction in self.directions.items():
            rotary, key, spring = axis.startswith("r"), f"directions.{axis}", direction.spring
            if isinstance(spring, Spring) and spring.stiffness is not None:
                check_unit(spring.stiffness, unit_of("stiffness", rotary), f"{key}.spring")
            check_unit(direction.damper, unit_of("damping", rotary), f"{key}.damper")
            if direction.zero is not None:
                check_unit(direction.zero, unit_of("position", rotary), f"{key}.zero")
            if direction.motor is not None:
                direction.motor.check_units(rotary, f"{key}.motor")
        if any(self.orientation) and all(
            one.motor is None and one.spring == "rigid" for one in self.directions.values()
        ):
            raise ValueError(
                "orientation turns a body in which no direction moves; turn the next body that has a direction, and "
                "state centre of mass, inertia and length of this one in the frame before it"
            )
        if self.bending:
            object.__setattr__(self, "bending", checked_bending(self))
            middle = tuple(component / 2.0 for component in self.length.value)
            object.__setattr__(self, "center_of_mass", self.center_of_mass.model_copy(update={"value": middle}))
        return self

    def straight_inertia(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return the inertia tensor about the centre of mass [kg m2], shape (3, 3), with that of a straight beam."""
        tensor = self.inertia.matrix()
        if self.bending:
            tensor += point_inertia(self.mass.value / 12.0, np.array(self.length.value))
        return tensor


class LinearTool(Settings):
    """Tool coordinate as a linear function of the arm coordinates, for models without geometry (Moberg 2007, eq. 8)."""

    component: Literal["x", "y", "z"] = "x"
    divisor: float = Field(1.0, gt=0, description="gear ratio by which the weighted sum is divided")
    weights: dict[str, float] = Field(description="arm coordinate -> distance [m]")


class Tool(Settings):
    """Tool point on the last body, or a linear tool coordinate."""

    position: Position | None = Field(None, description="in the frame of the last body [m]; default: its length")
    linear: LinearTool | None = None


class Output(Settings):
    """A set of controlled variables: pose components of the tool, or arm coordinates."""

    pose: tuple[PoseComponent, ...] = ()
    coordinates: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _one_kind(self) -> Output:
        if bool(self.pose) == bool(self.coordinates):
            raise ValueError("needs either 'pose' (x, y, z, rx, ry, rz) or 'coordinates' (names like body_1.ry)")
        return self


class Defaults(Settings):
    """Source and tolerance of all values that do not state their own."""

    source: str = ""
    tolerance: float = Field(0.0, ge=0, description="one standard deviation, relative")
    length_tolerance: float | None = Field(
        None, ge=0, description="the same of the lengths of bodies, which a drawing states; default: `tolerance`"
    )

    def tolerance_of(self, *, length: bool) -> float:
        """Return the tolerance of a value that states none, of a length or of another one [1]."""
        return self.length_tolerance if length and self.length_tolerance is not None else self.tolerance


class RobotSpecification(Settings):
    """A robot file (Moberg 2007, section 3.2.4 and Paper B, section 3)."""

    name: str
    description: str = ""
    defaults: Defaults = Field(default_factory=Defaults)
    coordinates: Literal["arm", "motor"] = Field("arm", description="side of the gear on which all values are stated")
    gravity: Acceleration = Field(
        default_factory=lambda: Vector(value=(0, 0, 0)), description="[m/s2]; exact unless it states a tolerance"
    )
    sample_time: Seconds = Field(default_factory=lambda: Quantity(value=5e-4, unit="s"), description="[s]")
    delay: Seconds = Field(default_factory=lambda: _zero("s"), description="of the command at the plant input [s]")
    inertial_coupling: bool = Field(
        False, description="include the coupling S(q) of the rotors (Moberg 2007, eq. 3.12)"
    )
    sensors: Sensors = Field(default_factory=Sensors)
    bodies: tuple[Body, ...] = Field(min_length=1, max_length=200)
    tool: Tool = Field(default_factory=Tool)
    outputs: dict[str, Output]
    inverse_kinematics: Literal["numerical", "two_link_elbow"] = Field(
        "numerical", description="two_link_elbow: closed form of a tool position [x, z] (Moberg 2007, eq. 3.26 to 3.28)"
    )
    controlled: str = Field(description="default output of trajectories and feedforward")
    home: tuple[float, ...] | None = Field(None, description="arm coordinates of the usual start pose; default: zeros")
    unknown_parameters: tuple[str, ...] = Field((), description="parameters that an identification estimates")
    tags: dict[str, str] = Field(default_factory=dict, description="free text, e.g. which values are chosen")
    drawing: str = Field(
        "",
        description="URDF whose shapes `flexros view` draws, relative to this file; the labels of the bodies name its "
        "links; default: bars along the lengths",
    )

    @model_validator(mode="after")
    def _consistent(self) -> RobotSpecification:
        for index, body in enumerate(self.bodies):
            before = f"body_{index}" if index else "base"
            if body.parent and body.parent != before:
                raise ValueError(
                    f"bodies[{index}] names parent '{body.parent}', but the chain is serial and the body before is "
                    f"'{before}': the chain is disconnected; reorder the bodies"
                )
        self._check_sensors()
        if self.sample_time.value <= 0:
            raise ValueError(f"sample_time is {self.sample_time.value:g} s, but must be positive")
        if self.controlled not in self.outputs:
            raise ValueError(f"controlled is '{self.controlled}', but outputs has only {', '.join(self.outputs)}")
        names = arm_names(self)
        for output_name, output in self.outputs.items():
            self._known(output.coordinates, names, f"outputs.{output_name}.coordinates")
        if self.tool.linear:
            self._known(tuple(self.tool.linear.weights), names, "tool.linear.weights")
        if self.home is not None and len(self.home) != len(names):
            raise ValueError(f"home has {len(self.home)} numbers, but the robot has {len(names)} arm coordinates")
        if not names:
            raise ValueError("the robot has no direction of motion; give at least one body a direction")
        return self

    def _check_sensors(self) -> None:
        """Refuse sensors whose joints or units do not fit the motors, also a common encoder noise."""
        directions = [entry for body in self.bodies for entry in body.directions.items()]
        if self.sensors.link is not None:
            turns = tuple(axis.startswith("r") for axis, direction in directions if direction.motor is not None)
            self.sensors.link.check_joints(turns, "sensors.link")
        for index, body in enumerate(self.bodies):
            for axis, direction in body.directions.items():
                if direction.motor is not None and direction.motor.encoder_noise is None:
                    unit = unit_of("position", axis.startswith("r"))
                    key = f"sensors.encoder_noise, which also applies to the motor of body_{index + 1}.{axis},"
                    check_unit(self.sensors.encoder_noise, unit, key)

    @staticmethod
    def _known(given: tuple[str, ...], allowed: tuple[str, ...], key: str) -> None:
        for name in given:
            if name not in allowed:
                raise ValueError(f"{key} names '{name}', but the arm coordinates are {', '.join(allowed)}")


def bending_name(body: int, axis: str, mode: int) -> str:
    """Return the name of the coordinate of a mode, e.g. "body_1.bending_rz_1", from indices that begin at 0."""
    return f"body_{body + 1}.bending_{axis}_{mode + 1}"


def arm_names(specification: RobotSpecification) -> tuple[str, ...]:
    """Return the arm coordinates in order, e.g. ("body_1.ry", "body_2.ry"), without rigid directions without motor.

    The modes of a link follow its directions.
    """
    names: list[str] = []
    for index, body in enumerate(specification.bodies):
        free = (axis for axis, direction in body.directions.items() if direction.motor or direction.spring != "rigid")
        names += [f"body_{index + 1}.{axis}" for axis in free]
        for axis, bending in body.bending.items():
            names += [bending_name(index, axis, mode) for mode in range(len(bending.listed()))]
    return tuple(names)
