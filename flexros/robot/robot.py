"""The robot: its file, parameters, symbolic model, kinematics and equilibria."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from flexros.config.settings import validate
from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError, unknown_name
from flexros.robot import equilibrium, inverse_kinematics
from flexros.robot.equilibrium_search import EquilibriumSearch
from flexros.robot.further_sensors import FurtherSensor, list_sensors
from flexros.robot.motors import RobotMotor, list_motors
from flexros.robot.parameters import Parameter, list_parameters, with_values
from flexros.robot.physical import check_physical
from flexros.robot.specification import RobotSpecification, arm_names
from flexros.robot.symbolic.chain import Chain, Coordinates, build_chain
from flexros.robot.symbolic.model import SymbolicModel

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import pandas as pd
    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray
    from flexros.robot.symbolic.chain import Joint

LIBRARY = Path(__file__).parent / "library"

_MODELS = 8
"""Symbolic models with free parameters that a robot keeps (chosen)."""

Commands = Literal["torque", "position"]
"""What commands a robot: torques of its motors, or positions that their servos follow."""


class Robot:
    """One robot: N arm coordinates, M motors.

    Attributes:
        spec: The validated robot file.
        source: File or name from which it was loaded.
        commands: Whether its input are motor torques, or positions that the servos of its file follow.
        elbow_links: Lengths of the two links [m] of a robot with the closed form of an elbow, else None.
    """

    def __init__(self, specification: RobotSpecification, source: str, commands: Commands = "torque") -> None:
        self.spec = specification
        self.source = source
        self.commands: Commands = commands
        self.chain: Chain = build_chain(specification)
        check_physical(specification, self.chain, source)
        declared = specification.inverse_kinematics == "two_link_elbow"
        self.elbow_links = inverse_kinematics.link_lengths(specification, self.chain, source) if declared else None

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.spec.name

    @property
    def n_arm(self) -> int:
        """Number of arm coordinates, N."""
        return len(self.chain.joints)

    @property
    def n_motors(self) -> int:
        """Number of motors, M."""
        return self.chain.n_motors

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates q = [q_a, q_m]; a motor behind a rigid gear has none of its own."""
        return self.n_arm + self.chain.n_motor_coordinates

    @property
    def is_rigid(self) -> bool:
        """Whether every coordinate has a motor of its own, without a spring between."""
        return self.n_coordinates == self.n_motors

    @cached_property
    def motors(self) -> tuple[RobotMotor, ...]:
        """The motors, in order."""
        return list_motors(self.chain)

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints from base to tool, one per arm coordinate."""
        return self.chain.joints

    @property
    def gear_rows(self) -> tuple[int, ...]:
        """Row of each motor's gear coordinate among the coordinates q, shape (M,); also its arm coordinate."""
        return self.chain.gear_rows

    @property
    def motor_rows(self) -> tuple[int, ...]:
        """Row of each motor's position among the coordinates q, shape (M,)."""
        return self.chain.motor_rows

    @property
    def spring_rows(self) -> tuple[int, ...]:
        """Rows of the coordinates with a spring: all of the arm but those behind a rigid gear."""
        return self.chain.spring_rows

    @property
    def flexible_motors(self) -> tuple[int, ...]:
        """Indices of the motors behind flexible gears, in the order of their own coordinates."""
        return self.chain.flexible_motors

    @property
    def stiff_motors(self) -> tuple[int, ...]:
        """Indices of the motors behind rigid gears, which move with their arm coordinates."""
        return self.chain.stiff_motors

    def arm_from_gears(self, gears: Coordinates) -> Coordinates:
        """Embed gear coordinates or rates (..., M) in arm coordinates (..., N); see `Chain.arm_from_gears`."""
        arm: Coordinates = self.chain.arm_from_gears(gears)
        return arm

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the motors in messages: motor_1, motor_2, ..."""
        return tuple(motor.name for motor in self.motors)

    @property
    def arm_names(self) -> tuple[str, ...]:
        """Names of the arm coordinates, e.g. body_1.ry."""
        return arm_names(self.spec)

    @property
    def sample_time(self) -> float:
        """Sample time of the controller [s]."""
        return self.spec.sample_time.value

    @property
    def delay(self) -> float:
        """Delay of the command at the plant input [s]."""
        return self.spec.delay.value

    @property
    def controlled(self) -> str:
        """Name of the default output of trajectories."""
        return self.spec.controlled

    @property
    def tool_noise(self) -> float:
        """Noise of the tool tracker, rms [m]."""
        return self.spec.sensors.tool_noise.value

    def sensor_noise(self, quantity: str) -> float | None:
        """Return the noise, rms, that the robot file declares for a further sensor; None where it does not.

        Args:
            quantity: Name in `flexros.record.further_sensors.SENSOR_QUANTITIES`.
        """
        sensors = self.spec.sensors
        declared = {
            "link position": sensors.link_encoder_noise,
            "joint torque": sensors.joint_torque_noise,
            "tool acceleration": sensors.accelerometer_noise,
            "tool turning rate": sensors.gyroscope_noise,
        }.get(quantity)
        if declared is not None:
            return declared.value
        return next((sensor.noise for sensor in self.further_sensors if sensor.quantity == quantity), 0.0) or None

    @cached_property
    def further_sensors(self) -> tuple[FurtherSensor, ...]:
        """Sensors beside the motor encoders, in the order in which the loop stacks their measurements."""
        return list_sensors(self.spec, self.n_motors)

    @cached_property
    def torque_limits(self) -> FloatArray:
        """Largest absolute motor torque [Nm or N], shape (M,); infinite for no limit."""
        return np.array([motor.torque_limit for motor in self.motors])

    @cached_property
    def speed_limits(self) -> FloatArray:
        """Largest speed of the direction of each motor [rad/s or m/s], shape (M,); infinite for no limit."""
        return np.array([motor.speed_limit for motor in self.motors])

    @cached_property
    def encoder_noise(self) -> FloatArray:
        """Noise of the encoders, rms [rad or m], shape (M,)."""
        common = self.spec.sensors.encoder_noise
        own = [motor.specification.encoder_noise for motor in self.motors]
        return np.array([(common if noise is None else noise).value for noise in own])

    @cached_property
    def rotor_turns(self) -> FloatArray:
        """Rotor angle per motor coordinate: gear ratios for files stated on the arm side, else 1, shape (M,)."""
        ratios = [motor.gear_ratio for motor in self.motors]
        return np.array(ratios) if self.spec.coordinates == "arm" else np.ones(self.n_motors)

    @cached_property
    def home(self) -> FloatArray:
        """Usual start pose, arm coordinates [rad or m], shape (N,)."""
        return np.array(self.spec.home or [0.0] * self.n_arm)

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters of the equations of motion by name, with unit, source and tolerance."""
        return list_parameters(self.spec)

    @cached_property
    def model(self) -> SymbolicModel:
        """Symbolic model with all parameters at their values."""
        return SymbolicModel(self.spec, self.chain)

    @cached_property
    def equilibrium_with_motors_held(self) -> EquilibriumSearch:
        """Search for the equilibrium with the motors held."""
        return EquilibriumSearch(self.model, "motors")

    @cached_property
    def equilibrium_with_gears_held(self) -> EquilibriumSearch:
        """Search for the equilibrium with the arm side of the gears held."""
        return EquilibriumSearch(self.model, "gears")

    def symbolic(self, parameters: Sequence[str] = ()) -> SymbolicModel:
        """Return the symbolic model with some parameters free.

        Args:
            parameters: Names of the free parameters, e.g. ("body_3.mass",); they become the argument p.

        Raises:
            InputError: A name is not a parameter of the robot.
        """
        return self._symbolic(tuple(parameters))

    @cached_property
    def _symbolic(self) -> Callable[[tuple[str, ...]], SymbolicModel]:
        return lru_cache(maxsize=_MODELS)(partial(SymbolicModel, self.spec, self.chain))

    def with_values(self, values: Mapping[str, float], source: str = "given values") -> Robot:
        """Return a robot with some values replaced.

        Args:
            values: New values (SI) by parameter name, also "sample_time" and "delay" [s], "encoder_noise" and
                "tool_noise" [rad or m, m].
            source: Origin of the change; prefix of error messages.

        Raises:
            InputError: A name is unknown or the new robot is not physical.
        """
        if not values:
            return self
        data = with_values(self.spec.model_dump(), self.spec, values, source)
        return robot_of(validate(RobotSpecification, data, source), source, self.commands)

    def commanded_by(self, commands: Commands) -> Robot:
        """Return the robot with another input; the same one where it has that input already.

        Args:
            commands: "torque", or "position" for its servos.

        Raises:
            InputError: A motor has no servo in the robot file.
        """
        if commands == self.commands:
            return self
        if commands == "position":
            self.check_servos()
        return robot_of(self.spec, self.source, commands)

    def check_servos(self) -> None:
        """Refuse a robot whose file does not state the servo of every motor.

        Raises:
            InputError: Names the motors without one.
        """
        without = [motor.name for motor in self.motors if motor.specification.servo is None]
        if without:
            raise InputError(
                f"the position loop of {', '.join(without)} is not stated: add the gains to each motor of robot "
                f"{self.name}, e.g. servo: {{stiffness: 50, damping: 1}} in Nm/rad and Nm s/rad with their tolerance, "
                "or record torques"
            )

    @cached_property
    def model_hash(self) -> str:
        """Fingerprint of the robot file for provenance, 16 hexadecimal digits."""
        text = json.dumps(self.spec.model_dump(mode="json", exclude={"drawing"}), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def forward_kinematics(self, q_a: ArrayLike, output: str | None = None) -> FloatArray:
        """Return an output [m, rad], shape (n_out,).

        Args:
            q_a: Arm coordinates [rad or m], shape (N,).
            output: Name of the output; default: the controlled one.
        """
        value: FloatArray = np.asarray(self.model.output(output)(self.check_arm(q_a), self.model.parameter_values))
        return value.ravel()

    def tool_pose(self, q_a: ArrayLike) -> FloatArray:
        """Return the tool pose [x y z qx qy qz qw] for arm coordinates of shape (N,), shape (7,)."""
        value: FloatArray = np.asarray(self.model.tool_pose(self.check_arm(q_a), self.model.parameter_values))
        return value.ravel()

    def inverse_kinematics(
        self,
        target: ArrayLike,
        near: ArrayLike | None = None,
        output: str | None = None,
        configuration: int | None = None,
    ) -> FloatArray:
        """Compute arm coordinates of the rigid chain for a value of an output; see `inverse_kinematics.solve`."""
        start = self.check_arm(self.home if near is None else near)
        return inverse_kinematics.solve(self, np.asarray(target, float), start, output, configuration)

    def equilibrium(self, q_a: ArrayLike | None = None, *, motor_position: ArrayLike | None = None) -> FloatArray:
        """Compute the equilibrium under gravity, for given actuated arm coordinates or given motor positions.

        Args:
            q_a: Arm coordinates [rad or m], shape (N,); the actuated ones are held, the others deflect.
            motor_position: Motor positions [rad or m], shape (M,), instead.

        Returns:
            State x = [q_a, q_m, 0, 0], shape (2 n_coordinates,).

        Raises:
            InputError: No equilibrium was found, for instance because springs are too soft for gravity.
        """
        if motor_position is not None:
            near = self.home if q_a is None else self.check_arm(q_a)
            return equilibrium.at_motor_position(self, np.asarray(motor_position, float), near)
        return equilibrium.at_arm_position(self, self.check_arm(self.home if q_a is None else q_a))

    def holding_torque(self, state: FloatArray) -> FloatArray:
        """Return the motor torque that holds an equilibrium state [Nm or N], shape (M,)."""
        return equilibrium.holding_torque(self, state)

    def to_pandas(self) -> pd.DataFrame:
        """Return the parameters by name, with value (SI), unit, tolerance [1] and source."""
        from flexros.robot.shown import parameters_frame

        return parameters_frame(self)

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.n_arm} arm coordinates, {self.n_motors} motors, from {self.source}>"

    def _repr_html_(self) -> str:
        from flexros.robot.shown import robot_html

        return robot_html(self)

    def check_arm(self, q_a: ArrayLike) -> FloatArray:
        """Return arm coordinates [rad or m] as an array of shape (N,).

        Raises:
            InputError: Wrong number of coordinates, or a value that is not finite.
        """
        array = np.atleast_1d(np.asarray(q_a, dtype=float))
        if array.shape != (self.n_arm,):
            raise InputError(
                f"{array.size} arm coordinates were given, but robot {self.name} has {self.n_arm} "
                f"({', '.join(self.arm_names)}); give one number for each"
            )
        if not np.all(np.isfinite(array)):
            raise InputError(f"arm coordinates are {array.tolist()}, but must be finite numbers; correct them")
        return array


def robot_names() -> tuple[str, ...]:
    """Return the names of the built-in robots."""
    return tuple(sorted(path.stem for path in LIBRARY.glob("*.yaml")))


def load_robot(name_or_path: str | Path) -> Robot:
    """Load a built-in robot or a robot file.

    Args:
        name_or_path: Built-in name such as "e12", or path of a YAML file.

    Raises:
        InputError: Unknown name, unreadable or invalid file, non-physical values.
    """
    path = LIBRARY / f"{name_or_path}.yaml"
    if str(name_or_path) not in robot_names():
        path = Path(name_or_path)
        if path.suffix not in (".yaml", ".yml"):
            raise unknown_name("robot", str(name_or_path), robot_names(), other="or the path of a .yaml file")
    source = str(path) if path.parent != LIBRARY else str(name_or_path)
    specification = validate(RobotSpecification, read_yaml(path), source)
    if specification.drawing:  # of the folder of the file, which changed copies no longer know
        drawing = str(path.absolute().parent / specification.drawing)
        specification = specification.model_copy(update={"drawing": drawing})
    return robot_of(specification, source)


def robot_from_data(data: Mapping[str, Any], source: str) -> Robot:
    """Build a robot from the content of a robot file.

    Args:
        data: Content of the file.
        source: Its origin; prefix of error messages.

    Raises:
        InputError: Invalid keys or non-physical values.
    """
    return robot_of(validate(RobotSpecification, data, source), source)


def robot_of(specification: RobotSpecification, source: str, commands: Commands = "torque") -> Robot:
    """Return the robot of a validated file; equal files share one object, with its symbolic model and equilibria.

    Args:
        specification: The file.
        source: Its origin; prefix of error messages.
        commands: Whether its input are motor torques, or positions that the servos of the file follow.

    Raises:
        InputError: Non-physical values.
    """
    return _robot_of(_RobotFile(specification.model_dump_json(), source, commands, specification))


@dataclass(frozen=True)
class _RobotFile:
    """A validated file, compared by its text."""

    text: str
    source: str
    commands: Commands
    specification: RobotSpecification = field(compare=False)


@lru_cache(maxsize=8)
def _robot_of(file: _RobotFile) -> Robot:
    return Robot(file.specification, file.source, file.commands)
