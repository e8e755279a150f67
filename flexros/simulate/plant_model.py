"""Robot and laws of its effects as functions of the loop."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.loop.functions import WRENCH_SIZE, LoopFunctions
from flexros.effects.delay import Delay
from flexros.errors import unknown_name
from flexros.robot.equilibrium_search import Equilibrium, EquilibriumSearch
from flexros.robot.parameters import SERVO
from flexros.simulate.implicit_step import implicit_step
from flexros.simulate.plant_equilibrium import PlantEquilibriumSearch, own_at_start, torque_beyond_command
from flexros.simulate.plant_rates import acting_torque, dynamics, rates_beside_motion
from flexros.simulate.plant_symbols import PlantSymbols
from flexros.simulate.plant_updates import step_updates
from flexros.simulate.sensor_outputs import feels_input, measured_sensors, sensor_outputs
from flexros.simulate.stages import Stages

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects.patching.placement import PlacedLaw
    from flexros.robot import Robot
    from flexros.robot.further_sensors import FurtherSensor
    from flexros.robot.symbolic.kinematics import Value


class PlantModel:
    """The simulated plant; its state is [q, v] of the robot, then the states of effects.

    Without laws its functions are those of the robot's model. Neutral laws are omitted.

    Args:
        robot: The robot.
        laws: Laws of effects at its locations.
        parameters: Names of the free parameters, of the robot or of laws, e.g. "coulomb_friction@motor_1.level".
        sensors: Sensors beside the motor encoders that the loop measures; default: none.

    Raises:
        InputError: A name is not a parameter of robot or laws.
    """

    def __init__(
        self,
        robot: Robot,
        laws: Sequence[PlacedLaw] = (),
        parameters: Sequence[str] = (),
        *,
        sensors: Sequence[FurtherSensor] = (),
    ) -> None:
        self.robot = robot
        self.sensors = tuple(sensors)
        self.parameter_names = tuple(parameters)
        known = {name for law in laws for name in law.parameters}
        of_robot = [name for name in parameters if name not in known]
        for name in of_robot:
            if name not in robot.parameters:
                raise unknown_name(f"parameter of robot {robot.name}", name, [*robot.parameters, *sorted(known)])
        acting = [law for law in laws if not law.effect.neutral or set(law.parameters) & set(parameters)]
        self._delays = [law for law in acting if isinstance(law.effect, Delay)]
        self.laws = tuple(law for law in acting if not isinstance(law.effect, Delay))
        of_model = [name for name in of_robot if f".{SERVO}" not in name]
        self.model = robot.symbolic(of_model) if of_model else robot.model
        felt = feels_input(robot, self.sensors)
        self._plant = PlantSymbols(robot, self.model, self.laws, self.parameter_names, holds_input=felt)
        self.robot_columns = self._plant.robot_columns

    @property
    def n_states(self) -> int:
        """Number of states, including those of effects."""
        return int(self._plant.x.numel())

    @property
    def nominal_values(self) -> FloatArray:
        """Values of the free parameters in robot and laws (SI), shape (n_parameters,)."""
        of_laws = {name: value for law in self.laws for name, value in law.parameters.items()}
        robot = self.robot.parameters
        values = [of_laws[name] if name in of_laws else robot[name].value for name in self.parameter_names]
        return np.array(values, dtype=float)

    @property
    def delay(self) -> float | tuple[float, ...]:
        """Delay of the commands [s]; one per motor if effects delay single motors."""
        return self.delay_from(self.robot.delay)

    def delay_from(self, common: float) -> float | tuple[float, ...]:
        """Add the delays of single motors to one of all [s]; one per motor if effects delay single motors.

        Args:
            common: Delay of all motors [s].
        """
        if not self._delays:
            return common
        delays = [common] * self.robot.n_motors
        for law in self._delays:
            assert isinstance(law.effect, Delay)
            delays[law.motor] += law.effect.time
        return tuple(delays)

    @property
    def moves_rest(self) -> bool:
        """Whether laws of effects change the equilibrium of the robot."""
        return bool(self._plant.laws.gears or self._plant.laws.arms)

    @cached_property
    def _equilibrium_search(self) -> EquilibriumSearch:
        return (
            PlantEquilibriumSearch(self._plant, self.parameter_names)
            if self.moves_rest
            else EquilibriumSearch(self.model)
        )

    def rest(self, near: FloatArray, parameters: FloatArray | None = None) -> Equilibrium:
        """Compute the equilibrium of the plant with its motors held.

        Args:
            near: Initial state of the robot [q, v] or coordinates q alone, with the motors at their held positions.
            parameters: Values of the free parameters (SI), shape (n_parameters,); default: `nominal_values`.

        Returns:
            State of the robot, shape (2 nq,), and holding torque of the motors [Nm or N], shape (M,).

        Raises:
            InputError: The springs do not balance gravity.
        """
        values = self.nominal_values if parameters is None else np.asarray(parameters, dtype=float)
        wanted = values if self.moves_rest else values[self.robot_columns]
        return self._equilibrium_search.find(np.array(near[: self.model.n_coordinates], dtype=float), wanted)

    def start(
        self,
        state: FloatArray,
        torque: FloatArray | None = None,
        parameters: FloatArray | None = None,
        *,
        time: float = 0.0,
    ) -> FloatArray:
        """Append the states of the effects to a state of the robot, in steady state at its coordinates.

        Masses attached to the arm move with it.

        Args:
            state: State of the robot [q, v], shape (2 nq,).
            torque: Steady commands [Nm or N], shape (M,); default: those that hold the robot.
            parameters: Values of the free parameters (SI), shape (n_parameters,); default: `nominal_values`.
            time: Time since the start of the run [s], for effects that depend on time.

        Returns:
            State of the plant, shape (n_states,).
        """
        extended = np.concatenate([state, np.zeros(self.n_states - len(state))])
        holds_input = self._plant.input_rows.start < self.n_states
        integrating = list(self._plant.integrating)
        if not self._plant.own_states.numel() and not holds_input and not integrating:
            return extended
        values = self.nominal_values if parameters is None else np.asarray(parameters, dtype=float)
        if torque is None:
            torque = np.zeros(self.robot.n_motors)
            filtered = self._plant.laws.position_filters
            if self._plant.laws.commands or filtered or holds_input or integrating:
                wanted = values if self.moves_rest else values[self.robot_columns]
                held = self._equilibrium_search.holding_torque(np.asarray(state[: self.model.n_coordinates]), wanted)
                torque = self.command_at_rest(state, held, values)
        if integrating:
            extended[self._plant.integral_rows] = self._integral_at_start(state, np.asarray(torque), values)[
                integrating
            ]
        extended[self._plant.led_rows] = np.asarray(torque)[list(self._plant.leading)]
        if self._plant.own_states.numel():
            extended[self._plant.own_rows] = self._own_at_start(extended, torque, values).full().ravel()
        if holds_input:
            extended[self._plant.input_rows] = [*torque, *np.zeros(WRENCH_SIZE)]
        for law in self.laws:
            begin, timed = self._plant.rows(law).start, law.effect.states_of_time(time)
            extended[begin : begin + len(timed)] = timed
        return extended

    def corrections(self, gain: FloatArray) -> FloatArray:
        """Extend a correction of the robot's state to the effects, whose deflections follow motor and arm.

        Args:
            gain: Change of [q, v] per unit of a prediction error, shape (2 nq, M).

        Returns:
            The same for the state of the plant, shape (n_states, M).
        """
        extended = np.zeros((self.n_states, gain.shape[1]))
        extended[: len(gain)] = gain
        for law, effect in self._plant.laws.gears:
            if effect.holds_deflection:
                index, joint = self._plant.joint(law)
                motor = 0.0 if joint.motor_coordinate is None else gain[self.model.n_arm + joint.motor_coordinate]
                extended[self._plant.rows(law)] = motor - gain[index]
        return extended

    def command_at_rest(self, state: FloatArray, torque: FloatArray, parameters: FloatArray) -> FloatArray:
        """Compute the command that produces a motor torque at rest.

        Args:
            state: State of the robot at rest, shape (2 nq,).
            torque: Required motor torque [Nm or N], shape (M,).
            parameters: Values of the free parameters (SI), shape (n_parameters,).

        Returns:
            Command [Nm or N; of servos rad or m], shape (M,); for torques beyond a saturation the torque itself.
        """
        servos = self.robot.commands == "position"
        if not servos and not self._plant.laws.torques and not self._plant.laws.commands:
            return torque
        extended = np.concatenate([state, np.zeros(self.n_states - len(state))])
        if servos:
            return np.where(
                self._servo_gains("integral", parameters) > 0,
                self._measured(extended, parameters).full().ravel(),
                self._sagging(state, torque, parameters),
            )
        beyond, slope = (value.full() for value in self._torque_beyond_command(extended, torque, parameters))
        # the laws are linear in the torque, so one Newton step is exact
        step = np.linalg.lstsq(np.eye(len(torque)) + slope, beyond.ravel(), rcond=None)[0]
        command: FloatArray = torque - step
        return command

    def _sagging(self, state: FloatArray, torque: FloatArray, parameters: FloatArray) -> FloatArray:
        """Compute the commands of servos without integral parts, as `command_at_rest`."""
        extended = np.concatenate([state, np.zeros(self.n_states - len(state))])
        near = self._measured(extended, parameters).full().ravel()  # where no torque limit is reached
        beyond, slope = (value.full() for value in self._torque_beyond_command(extended, near, parameters))
        lacking = beyond.ravel() + near - torque
        return np.asarray(near - np.linalg.lstsq(np.eye(len(near)) + slope, lacking, rcond=None)[0])

    def _integral_at_start(self, state: FloatArray, command: FloatArray, parameters: FloatArray) -> FloatArray:
        """Compute the integral parts of servos that carry what their other parts do not, shape (M,)."""
        stiffness, damping, integral = (
            self._servo_gains(name, parameters) for name in ("stiffness", "damping", "integral")
        )
        n = self.model.n_coordinates
        wanted = parameters if self.moves_rest else parameters[self.robot_columns]
        held = self._equilibrium_search.holding_torque(np.asarray(state[:n]), wanted)
        speed = np.asarray(state[n:])[list(self.robot.motor_rows)]
        carried = stiffness * (self._sagging(state, held, parameters) - command) + damping * speed
        limits = self.robot.torque_limits
        return np.where(integral > 0, np.clip(carried, -limits, limits), 0.0)

    def _servo_gains(self, kind: str, parameters: FloatArray) -> FloatArray:
        """Return a number of all servos, shape (M,)."""
        values = dict(zip(self.parameter_names, parameters, strict=True))
        names = [f"{motor}.{SERVO}{kind}" for motor in self.robot.joint_names]
        return np.array([values[name] if name in values else self.robot.parameters[name].value for name in names])

    @property
    def friction_follows_speed(self) -> bool:
        """Whether the plant has dry friction that depends on the speed."""
        return any(effect.depends_on_speed for _, effect in self._plant.laws.frictions)

    def functions(self, controller: ca.Function, *, implicit: bool = False, placed: bool = False) -> LoopFunctions:
        """Return the functions of the loop.

        Args:
            controller: Controller (c, r, y, g) -> (u, c_next).
            implicit: Whether its steps are implicit in the stiffness and the damping of the motors.
            placed: Whether dry friction that jumps within a step also moves the motors by what that adds to its mean.
        """
        before, after = step_updates(self._plant, implicit=implicit, placed=placed)
        return LoopFunctions(
            derivative=self.derivative,
            encoder=self.model.encoder,
            tool_pose=self._tool_pose,
            controller=controller,
            sensor=self._sensor,
            further=self.further if self.sensors else None,
            before_step=before,
            after_step=after,
            step=implicit_step(self._plant) if implicit else None,
        )

    @cached_property
    def further(self) -> ca.Function:
        """Values of the sensors beside the encoders from (x, p), without noise."""
        return measured_sensors(self._plant, self.derivative, self.sensors)

    @cached_property
    def derivative(self) -> ca.Function:
        """State derivative from (x, u, w, p)."""
        plant = self._plant
        if not self.laws and self.robot.commands == "torque" and plant.x.numel() == 2 * self.model.n_coordinates:
            return self.model.derivative
        stages = Stages([plant.x, plant.u, plant.w, plant.p])
        function, inputs = dynamics(plant, acting_torque(plant))
        rates = ca.vertcat(plant.v, stages.call(function, *inputs)[0], rates_beside_motion(plant))
        return stages.function("derivative", rates)

    def sensor_outputs(self, wanted: Sequence[tuple[str, int]]) -> ca.Function:
        """Return the outputs of further sensors from (x, u, p), see `flexros.simulate.sensor_outputs`.

        Args:
            wanted: Quantity and number of the motor or of the axis, of each sensor.
        """
        return sensor_outputs(self._plant, self.derivative, wanted)

    def sensor_slopes(self, wanted: Sequence[tuple[str, int]], state: FloatArray) -> FloatArray:
        """Return the derivatives of these outputs to the state of the robot, shape (n_sensors, 2 nq).

        Args:
            wanted: Quantity and number of the motor or of the axis, of each sensor.
            state: State of the robot [q, v], shape (2 nq,).
        """
        x, u, p = self._plant.x, self._plant.u, self._plant.p
        slopes = ca.jacobian(self.sensor_outputs(wanted)(x, u, p), x[: len(state)])
        found = ca.Function("slopes", [x, u, p], [slopes])
        held = np.zeros(self.robot.n_motors)
        return np.asarray(found(self.start(state, held), held, self.nominal_values).full())

    @cached_property
    def _tool_pose(self) -> ca.Function:
        plant, errors = self._plant, self._plant.laws.tool_errors
        if not errors and len(self.robot_columns) == len(self.parameter_names):
            return self.model.tool_pose
        qa = ca.SX.sym("q_a", self.model.n_arm)
        moved = ca.SX(qa)
        geometry: dict[str, Value] = {}
        for law, effect in errors:
            for name, value in effect.offsets(self.robot, law.location, plant.values(law)).items():
                moved[self.robot.arm_names.index(name)] += value
            for name, value in effect.geometry(self.robot, law.location, plant.values(law)).items():
                before = geometry[name] if name in geometry else plant.robot_value(name)
                geometry[name] = before + value
        if not geometry:
            pose = self.model.tool_pose(moved, plant.robot_parameters)
        else:
            others = [name for name in self.model.parameter_names if name not in geometry]
            values = ca.vertcat(*geometry.values(), *[plant.robot_value(name) for name in others])
            pose = self.robot.symbolic([*geometry, *others]).tool_pose(moved, values)
        return ca.Function("tool_pose", [qa, plant.p], [ca.densify(pose)])

    @cached_property
    def _sensor(self) -> ca.Function | None:
        plant, sensors = self._plant, self._plant.laws.sensors
        if not sensors:
            return None
        y = ca.SX.sym("y", self.robot.n_motors)
        measured = ca.SX(y)
        for law, effect in sensors:
            motor = law.motor
            angle = plant.motor(law, plant.u).angle
            measured[motor] = effect.read(measured[motor], angle, plant.values(law))
        return ca.Function("sensor", [y, plant.x, plant.p], [ca.densify(measured)])

    @cached_property
    def _measured(self) -> ca.Function:
        """Positions that servos act on, from (x, p)."""
        plant = self._plant
        measured = ca.vertcat(*[plant.measured(index) for index in range(self.robot.n_motors)])
        return ca.Function("measured", [plant.x, plant.p], [ca.densify(measured)])

    @cached_property
    def _torque_beyond_command(self) -> ca.Function:
        return torque_beyond_command(self._plant)

    @cached_property
    def _own_at_start(self) -> ca.Function:
        plant = self._plant
        own = ca.densify(own_at_start(plant, plant.u))
        return ca.Function("own_at_start", [plant.x, plant.u, plant.p], [own])
