"""Robot and laws of its effects together, as functions of the loop."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.loop_functions import WRENCH_SIZE, LoopFunctions
from flexros.effects.dry_friction import AHEAD, AbstractDryFriction, FrictionLevels, mean_friction
from flexros.effects.motor_law import AbstractMotorTorque, MotorState
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects.placement import PlacedLaw
    from flexros.robot import Robot
    from flexros.robot.kinematics import Value

SWEEPS = 4
"""Passes over the motors whose frictions act on each other, per step twice that; each starts from the last (chosen)."""


class PlantModel:
    """The simulated plant; its state is that of the robot, [q, v], then the friction torques of motors that can stick.

    Without laws its functions are those of the robot's own model. Laws whose size is zero are left out.

    Args:
        robot: The robot.
        laws: Laws of effects at its motors.
        parameters: Names of the free parameters, of the robot or of laws, e.g. "coulomb_friction@motor_1.level".

    Raises:
        InputError: A name is not a parameter of robot or laws.
    """

    def __init__(self, robot: Robot, laws: Sequence[PlacedLaw] = (), parameters: Sequence[str] = ()) -> None:
        self.robot = robot
        self.parameter_names = tuple(parameters)
        known = {name for law in laws for name in law.parameters}
        of_robot = [name for name in parameters if name not in known]
        for name in of_robot:
            if name not in robot.parameters:
                raise unknown_name(f"parameter of robot {robot.name}", name, [*robot.parameters, *sorted(known)])
        self.laws = tuple(law for law in laws if not law.effect.neutral or set(law.parameters) & set(parameters))
        self.model = robot.symbolic(of_robot) if of_robot else robot.model
        self.robot_columns = [self.parameter_names.index(name) for name in of_robot]
        self._places = robot.chain.motor_places
        self._rubbing = tuple(sorted({law.motor for law in self.laws if isinstance(law.effect, AbstractDryFriction)}))
        nq, m = self.model.n_coordinates, robot.n_motors
        self._x = ca.SX.sym("x", 2 * nq + len(self._rubbing))
        self._u, self._w = ca.SX.sym("u", m), ca.SX.sym("w", WRENCH_SIZE)
        self._p = ca.SX.sym("p", len(self.parameter_names))
        self._symbols = {name: self._p[index] for index, name in enumerate(self.parameter_names)}

    def start(self, state: FloatArray) -> FloatArray:
        """Put the states of the effects behind a state of the robot.

        Args:
            state: State of the robot [q, v], shape (2 nq,).

        Returns:
            State of the plant, shape (n_states,).
        """
        return np.concatenate([state, np.zeros(len(self._rubbing))])

    def command_at_rest(self, state: FloatArray, torque: FloatArray, parameters: FloatArray) -> FloatArray:
        """Find the command under which the motors get a torque, at rest.

        Args:
            state: State of the robot at rest, shape (2 nq,).
            torque: Torque that is needed at the motors [Nm or N], shape (M,).
            parameters: Values of the free parameters (SI), shape (n_parameters,).

        Returns:
            Command [Nm or N], shape (M,).
        """
        if not self._smooth_laws:
            return torque
        added, slope = (value.full() for value in self._torque_and_slope(self.start(state), torque, parameters))
        # the laws are linear in the torque, so that one Newton step is exact
        command: FloatArray = torque - np.linalg.solve(np.eye(len(torque)) + slope, added.ravel())
        return command

    def functions(self, controller: ca.Function) -> LoopFunctions:
        """Put plant and controller together.

        Args:
            controller: Update (c, r, y, g) -> (u, c_next).

        Returns:
            The functions from which the loop is compiled.
        """
        return LoopFunctions(
            derivative=self.derivative,
            encoder=self.model.encoder,
            tool_pose=self._tool_pose,
            controller=controller,
            exact_update=self._exact_update,
        )

    @cached_property
    def derivative(self) -> ca.Function:
        """State derivative from (x, u, w, p)."""
        if not self.laws:
            return self.model.derivative
        torque = self._u + self._smooth_torque
        n = 2 * self.model.n_coordinates
        for place, motor in enumerate(self._rubbing):
            torque[motor] -= self._x[n + place]
        robot = self.model.derivative(self._x[:n], torque, self._w, self._robot_parameters)
        return self._function("derivative", [ca.vertcat(robot, ca.SX.zeros(len(self._rubbing)))])

    @property
    def _robot_parameters(self) -> ca.SX:
        return ca.vertcat(ca.SX(0, 1), *[self._p[column] for column in self.robot_columns])

    @cached_property
    def _tool_pose(self) -> ca.Function:
        if len(self.robot_columns) == len(self.parameter_names):
            return self.model.tool_pose
        qa = ca.SX.sym("q_a", self.model.n_arm)
        pose = self.model.tool_pose(qa, self._robot_parameters)
        return ca.Function("tool_pose", [qa, self._p], [pose])

    def _values(self, law: PlacedLaw) -> Mapping[str, Value]:
        own = law.parameters.items()
        return {name.rpartition(".")[2]: self._symbols.get(name, value) for name, value in own}

    @property
    def _smooth_laws(self) -> list[tuple[PlacedLaw, AbstractMotorTorque]]:
        return [(law, law.effect) for law in self.laws if isinstance(law.effect, AbstractMotorTorque)]

    @cached_property
    def _smooth_torque(self) -> ca.SX:
        torque = ca.SX.zeros(self.robot.n_motors)
        for law, effect in self._smooth_laws:
            torque[law.motor] += effect.added(self._motor(law.motor), self._values(law))
        return torque

    def _motor(self, number: int) -> MotorState:
        place = self._places[number]
        turns = self.robot.chain.motor(number).gear_ratio.value if self.robot.spec.coordinates == "arm" else 1.0
        position = self._x[place]
        speed = self._x[self.model.n_coordinates + place]
        return MotorState(position, turns * position, speed, self._u[number])

    @cached_property
    def _torque_and_slope(self) -> ca.Function:
        torque = ca.densify(self._smooth_torque)
        return ca.Function("torque", [self._x, self._u, self._p], [torque, ca.densify(ca.jacobian(torque, self._u))])

    @cached_property
    def _exact_update(self) -> ca.Function | None:
        """Friction torques for a step of 2 h from (x, u, w, p, h), see `flexros.effects.dry_friction`; None for none.

        The loop calls it before a step, where it counts, and again after it, where it is without consequence: the
        friction torque has no part in what is measured and is computed anew before the next step.
        """
        if not self._rubbing:
            return None
        nq = self.model.n_coordinates
        half = ca.SX.sym("h")
        torque = ca.SX.sym("torque", self.robot.n_motors)
        q, v, friction = ca.vertsplit(self._x, [0, nq, 2 * nq, self._x.numel()])
        places = [self._places[motor] for motor in self._rubbing]
        free = self.model.acceleration(q, v, torque, self._w, self._robot_parameters)[places]
        mobility = ca.jacobian(free, torque)[:, list(self._rubbing)]
        free = ca.substitute(free, torque, self._u + self._smooth_torque)
        free = free + AHEAD * 2 * half * ca.jtimes(free, q, v)
        for _ in range(1 if mobility.sparsity().is_diag() else SWEEPS):
            for place, motor in enumerate(self._rubbing):
                own = mobility[place, place]
                acceleration = free[place] - mobility[place, :] @ friction + own * friction[place]
                speed = v[places[place]]
                friction[place] = mean_friction(speed, acceleration, own, self._levels(motor, speed), 2 * half)
        arguments = [self._x, self._u, self._w, self._p, half]
        return ca.Function("exact_update", arguments, [ca.densify(ca.vertcat(q, v, friction))], {"cse": True})

    def _levels(self, motor: int, speed: ca.SX) -> FrictionLevels:
        total = FrictionLevels(ca.SX(0), ca.SX(0))
        for law in self.laws:
            if law.motor == motor and isinstance(law.effect, AbstractDryFriction):
                total = total + law.effect.levels(speed, self._values(law))
        return total

    def _function(self, name: str, outputs: list[ca.SX]) -> ca.Function:
        arguments = [self._x, self._u, self._w, self._p]
        return ca.Function(name, arguments, [ca.densify(output) for output in outputs], {"cse": True})
