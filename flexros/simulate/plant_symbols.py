"""Symbolic state of a plant with effects, and the view of it passed to each kind of law."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.loop.functions import WRENCH_SIZE
from flexros.effects.kinds.arm_law import ArmState
from flexros.effects.kinds.gear_law import GearState
from flexros.effects.kinds.motor_law import MotorState
from flexros.robot.parameters import SERVO
from flexros.robot.spring import Spring
from flexros.simulate.laws_by_kind import LawsByKind

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.patching.placement import PlacedLaw
    from flexros.robot import Robot
    from flexros.robot.symbolic.chain import Joint
    from flexros.robot.symbolic.kinematics import Value
    from flexros.robot.symbolic.model import SymbolicModel

LEAD = ("feedforward", "damping", "stiffness")
"""Numbers of a servo that make its lead."""


class PlantSymbols:
    """Symbols of a plant: its state is [q, v], friction torques of motors with dry friction, own states of the laws.

    The torques of the integral parts of servos come after these.

    Args:
        robot: The robot.
        model: Its symbolic model.
        laws: Laws of effects.
        names: Names of all free parameters, of the robot and of the laws.
        holds_input: Whether the last states are the motor torques and the wrench that act, for sensors that feel them.

    Attributes:
        laws: Laws by kind.
        x: State of the plant.
        u: Commands: motor torques, or positions of servos, shape (M,).
        w: Wrench at the tool.
        p: Free parameters.
        sticking_motors: Indices of the motors with dry friction.
        robot_columns: Indices of the robot's free parameters in `p`.
        own_rows: Rows of the own states of all laws.
        integrating: Indices of the motors whose servo has an integral part.
        integral_rows: Rows of the torques of these.
        input_rows: Rows of the input that is held; none without `holds_input`.
    """

    def __init__(
        self,
        robot: Robot,
        model: SymbolicModel,
        laws: Sequence[PlacedLaw],
        names: Sequence[str],
        *,
        holds_input: bool = False,
    ) -> None:
        self.robot, self.model, self.laws = robot, model, LawsByKind(tuple(laws))
        self.robot_columns = [names.index(name) for name in model.parameter_names]
        self.sticking_motors = tuple(sorted({law.motor for law, _ in self.laws.frictions}))
        end = self.friction_end = 2 * model.n_coordinates + len(self.sticking_motors)
        self._rows: dict[str, slice] = {}
        for law in self.laws.all:
            self._rows[law.name] = slice(end, end + law.effect.n_states)
            end += law.effect.n_states
        self.own_rows = slice(self.friction_end, end)
        self.integrating = tuple(motor.index for motor in robot.motors if self._integrates(motor.name, names))
        self.integral_rows = slice(end, end + len(self.integrating))
        self.leading = tuple(index for index in self.integrating if self._leads(robot.joint_names[index], names))
        self.led_rows = slice(self.integral_rows.stop, self.integral_rows.stop + len(self.leading))
        end = self.led_rows.stop
        self.input_rows = slice(end, end + (robot.n_motors + WRENCH_SIZE if holds_input else 0))
        self.x = ca.SX.sym("x", self.input_rows.stop)
        self.u, self.w = ca.SX.sym("u", robot.n_motors), ca.SX.sym("w", WRENCH_SIZE)
        self.p = ca.SX.sym("p", len(names))
        self._free = {name: self.p[index] for index, name in enumerate(names)}

    @property
    def q(self) -> ca.SX:
        """Coordinates."""
        return self.x[: self.model.n_coordinates]

    @property
    def v(self) -> ca.SX:
        """Rates of the coordinates."""
        return self.x[self.model.n_coordinates : 2 * self.model.n_coordinates]

    @property
    def friction(self) -> ca.SX:
        """Friction torques of the motors with dry friction."""
        return self.x[2 * self.model.n_coordinates : self.friction_end]

    @property
    def own_states(self) -> ca.SX:
        """States of all laws."""
        return self.x[self.own_rows]

    @property
    def robot_parameters(self) -> ca.SX:
        """Argument p of the functions of the robot's model."""
        return ca.vertcat(ca.SX(0, 1), *[self.p[column] for column in self.robot_columns])

    def rows(self, law: PlacedLaw) -> slice:
        """Return the rows of a law's own states in the state of the plant."""
        return self._rows[law.name]

    def own(self, law: PlacedLaw) -> ca.SX:
        """Return the own states of a law."""
        return self.x[self._rows[law.name]]

    def values(self, law: PlacedLaw) -> Mapping[str, Value]:
        """Return the value or symbol of every parameter of a law."""
        own = law.parameters.items()
        return {name.rpartition(".")[2]: self._free.get(name, value) for name, value in own}

    def robot_value(self, name: str) -> Value:
        """Return the value or symbol of a parameter of the robot."""
        value: Value = self._free[name] if name in self._free else self.robot.parameters[name].value
        return value

    def followed(self, commands: ca.SX) -> ca.SX:
        """Return the commands that servos follow, behind their filters; torques are not filtered."""
        commands = ca.SX(commands)
        if self.robot.commands == "position":
            for law, effect in self.laws.position_filters:
                commands[law.motor] = effect.passed(commands[law.motor], self.own(law), self.values(law))
        return commands

    def driven(self, commands: ca.SX, *, limited: bool = True) -> ca.SX:
        """Return the torques for followed commands: they themselves, or those of servos within their limits."""
        if self.robot.commands == "torque":
            return ca.SX(commands)
        torques = []
        for motor in self.robot.motors:
            torque, limit = self._unlimited(motor.index, commands), motor.torque_limit if limited else math.inf
            torques.append(ca.fmin(ca.fmax(torque, -limit), limit) if math.isfinite(limit) else torque)
        return ca.vertcat(*torques)

    def integral_rates(self, commands: ca.SX) -> ca.SX:
        """Return the rates of the integral parts of servos, zero where a torque at its limit would go beyond it."""
        rates = []
        for index in self.integrating:
            motor = self.robot.motors[index]
            led = index in self.leading  # commands come with the lead of the feedforward, which no error is
            wanted = self.x[self.led_rows.start + self.leading.index(index)] if led else commands[index]
            error, limit = wanted - self.measured(index), motor.torque_limit
            rate = self.robot_value(f"{motor.name}.{SERVO}integral") * error
            if math.isfinite(limit):
                torque = self._unlimited(index, commands)
                rate = ca.if_else(ca.logic_and(ca.fabs(torque) > limit, torque * error > 0), 0, rate)
            rates.append(rate)
        return ca.vertcat(ca.SX(0, 1), *rates)

    def _integrates(self, motor: str, names: Sequence[str]) -> bool:
        """Return whether the servo of a motor has an integral part, or may have one as a free parameter."""
        if self.robot.commands == "torque":
            return False
        name = f"{motor}.{SERVO}integral"
        return name in names or self.robot.parameters[name].value != 0

    def _leads(self, motor: str, names: Sequence[str]) -> bool:
        """Return whether the servo of a motor follows the rate of its command, or may do so by a free parameter."""
        name = f"{motor}.{SERVO}feedforward"
        return name in names or self.robot.parameters[name].value != 0

    def without_lead(self, commands: ca.SX, step: ca.SX) -> ca.SX:
        """Return the positions of leading servos after a step, of which the commands are that plus lead times rate."""
        found = []
        for row, index in enumerate(self.leading):
            gains = {kind: self.robot_value(f"{self.robot.joint_names[index]}.{SERVO}{kind}") for kind in LEAD}
            lead = gains["feedforward"] * gains["damping"] / gains["stiffness"]
            before, command = self.x[self.led_rows.start + row], commands[index]
            found.append(command + (before - command) * ca.exp(-step / ca.fmax(lead, 1e-12)))
        return ca.vertcat(ca.SX(0, 1), *found)

    def measured(self, index: int) -> ca.SX:
        """Return the position that the servo of a motor acts on: as its encoder shows it, without noise and steps."""
        motor = self.robot.motors[index]
        position = self.q[motor.row]
        angle = float(self.robot.rotor_turns[index]) * position
        for law, effect in self.laws.sensors:
            if law.motor == index and not effect.as_noise:
                position = effect.read(position, angle, self.values(law))
        return position

    def _unlimited(self, index: int, commands: ca.SX) -> ca.SX:
        """Return the torque of a servo without its limit."""
        motor = self.robot.motors[index]
        gain = {name: self.robot_value(f"{motor.name}.{SERVO}{name}") for name in ("stiffness", "damping")}
        torque = gain["stiffness"] * (commands[index] - self.measured(index)) - gain["damping"] * self.v[motor.row]
        if index in self.integrating:
            torque += self.x[self.integral_rows.start + self.integrating.index(index)]
        return torque

    def torques(self, commands: ca.SX, *, limited: bool = True) -> ca.SX:
        """Return the motor torques for commands, after filters, saturation, gain and lag.

        Args:
            commands: Commands of all motors.
            limited: Whether servos keep to the torque limits of the robot file.
        """
        torque = self.driven(self.followed(commands), limited=limited)
        for law, effect in self.laws.commands:
            motor = law.motor
            torque[motor] = effect.passed(torque[motor], self.own(law), self.values(law))
        return torque

    def of_motors(self, values: ca.SX) -> ca.SX:
        """Return values of all motors at the coordinates of these, zero elsewhere, SX (n_coordinates, 1)."""
        placed = ca.SX.zeros(self.model.n_coordinates)
        placed[list(self.robot.motor_rows)] = values
        return placed

    def motor(self, law: PlacedLaw, torque: ca.SX) -> MotorState:
        """Return the motor state for a law at a motor; `torque` is that of all motors."""
        row = self.robot.motor_rows[law.motor]
        position, speed = self.q[row], self.v[row]
        angle = float(self.robot.rotor_turns[law.motor]) * position
        friction = self.robot_value(f"{law.location}.viscous_friction")
        return MotorState(position, angle, speed, torque[law.motor], self.own(law), friction)

    def joint(self, law: PlacedLaw) -> tuple[int, Joint]:
        """Return the arm coordinate of a spring law, located by the name of a motor or of the joint."""
        joints = self.robot.joints
        names = self.robot.joint_names
        index = (
            self.robot.gear_rows[names.index(law.location)]
            if law.location in names
            else [joint.name for joint in joints].index(law.location)
        )
        return index, joints[index]

    def gear(self, law: PlacedLaw) -> GearState:
        """Return the state of the spring for a law, as changed by the laws of lower rank."""
        index = self.joint(law)[0]
        gear = self.nominal_gear(index)
        for other, effect in self.laws.gears:
            if other is law:
                break
            if self.joint(other)[0] == index:
                gear = effect.onward(replace(gear, own=self.own(other)), self.values(other))
        return replace(gear, own=self.own(law))

    def gear_torque(self, motor: int) -> ca.SX:
        """Return the torque from a flexible gear to the arm, with all laws in it."""
        row = self.robot.gear_rows[motor]
        torque = self.nominal_gear(row).torque
        for law, effect in self.laws.gears:
            if self.joint(law)[0] == row:
                torque += effect.added(self.gear(law), self.values(law)).arm
        return torque

    def nominal_gear(self, index: int) -> GearState:
        """Return the state of the spring at an arm coordinate, without laws."""
        joint = self.robot.joints[index]
        spring, scale = joint.direction.spring, self.robot_value(f"{joint.name}.stiffness")
        assert isinstance(spring, Spring)
        damping = self.robot_value(f"{joint.name}.damping")
        if joint.motor_coordinate is None:
            motor, speed, turns = ca.SX(0), ca.SX(0), 0.0
        else:
            row = self.model.n_arm + joint.motor_coordinate
            assert joint.motor is not None
            motor, speed, turns = self.q[row], self.v[row], float(self.robot.rotor_turns[joint.motor])
        deflection, rate = motor - self.q[index], speed - self.v[index]
        return GearState(
            deflection=deflection,
            rate=rate,
            angle=turns * motor,
            motor_speed=speed,
            turns=turns,
            torque=spring.force(deflection, scale) + damping * rate,
            damping=damping,
            spring=partial(spring.force, scale=scale),
            own=ca.SX(0, 1),
        )

    def arm(self, law: PlacedLaw) -> ArmState:
        """Return the state of the arm for a law."""
        n = self.model.n_arm
        return ArmState(
            position=self.q[:n],
            speed=self.v[:n],
            motor_position=self.q[n:],
            motor_speed=self.v[n:],
            model=self.model,
            parameters=self.robot_parameters,
            robot=self.robot,
            location=law.location,
            own=self.own(law),
        )

    def added_force(self) -> ca.SX | None:
        """Return the forces of all spring and arm laws on the coordinates; None without such laws."""
        gears, arms = self.laws.gears, self.laws.arms
        if not gears and not arms:
            return None
        force = ca.SX.zeros(self.model.n_coordinates)
        for law, effect in gears:
            torques = effect.added(self.gear(law), self.values(law))
            index, joint = self.joint(law)
            force[index] += torques.arm
            if joint.motor_coordinate is not None:
                force[self.model.n_arm + joint.motor_coordinate] += torques.motor
        for law, arm_effect in arms:
            added = arm_effect.force(self.arm(law), self.values(law))
            force[: added.numel()] += added
        return force
