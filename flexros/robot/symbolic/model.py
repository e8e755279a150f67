"""The extended flexible joint model as one symbolic graph (Moberg 2007, eq. 3.18 and Paper B, eq. 2)."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.errors import unknown_name
from flexros.robot.parameters import list_parameters
from flexros.robot.spring import Spring
from flexros.robot.symbolic import dynamics, inertial_coupling, kinematics
from flexros.robot.symbolic.transmission import Transmission, build_transmission

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot.specification import RobotSpecification
    from flexros.robot.symbolic.chain import Chain
    from flexros.robot.symbolic.kinematics import Geometry, Value


class SymbolicModel:
    """CasADi functions of one robot, all from one graph.

    The state is x = [q, v] with q = [q_a, q_m]: arm coordinates, then the coordinates of motors behind a flexible gear.
    Inputs are the motor torques u, shape (M,), and a wrench w at the tool in the base frame, [fx fy fz tx ty tz].

    Attributes:
        parameter_names: Names of the free parameters, in the order of the argument p.
        parameter_values: Their nominal values (SI), shape (n_p,).
        n_arm: Number of arm coordinates, N.
        n_motors: Number of motors, M.
        n_coordinates: Number of coordinates q.
    """

    def __init__(self, specification: RobotSpecification, chain: Chain, parameters: Sequence[str] = ()) -> None:
        known = list_parameters(specification)
        for name in parameters:
            if name not in known:
                raise unknown_name(f"parameter of robot {specification.name}", name, known)
        self.specification = specification
        self.chain = chain
        self.parameter_names = tuple(parameters)
        self.parameter_values: FloatArray = np.array([known[name].value for name in parameters], dtype=float)
        self.n_arm = len(chain.joints)
        self.n_motors = chain.n_motors
        self.n_coordinates = self.n_arm + chain.n_motor_coordinates
        self._p = ca.SX.sym("p", len(parameters))
        symbols = {name: self._p[index] for index, name in enumerate(parameters)}
        self._values: dict[str, Value] = {name: symbols.get(name, known[name].value) for name in known}
        self._geometry: Geometry = kinematics.build_geometry(specification, chain, self._values.__getitem__)
        self._gravity = ca.vertcat(*[ca.SX(self._values[f"gravity.{axis}"]) for axis in "xyz"])
        self._q = ca.SX.sym("q", self.n_coordinates)
        self._v = ca.SX.sym("v", self.n_coordinates)
        self._u = ca.SX.sym("u", self.n_motors)
        self._w = ca.SX.sym("w", 6)
        self._outputs: dict[str, ca.Function] = {}
        self._outputs_with_slope: dict[str, ca.Function] = {}
        self._linearised: dict[str, ca.Function] = {}

    @property
    def _qa(self) -> ca.SX:
        return self._q[: self.n_arm]

    @property
    def _va(self) -> ca.SX:
        return self._v[: self.n_arm]

    def _function(self, name: str, inputs: list[ca.SX], outputs: list[ca.SX], names: list[str]) -> ca.Function:
        """Build a function with dense outputs and common subexpression elimination."""
        dense = [ca.densify(ca.SX(output)) for output in outputs]
        return ca.Function(name, inputs, dense, names, [f"out{i}" for i in range(len(dense))], {"cse": True})

    @cached_property
    def _transmission(self) -> Transmission:
        return build_transmission(self.chain, self._values, self._q, self._v)

    @cached_property
    def _motor_inertia(self) -> ca.SX:
        names = [f"motor_{number + 1}.inertia" for number in self.chain.flexible_motors]
        return ca.vertcat(*[ca.SX(self._values[name]) for name in names])

    @cached_property
    def _coupling(self) -> ca.SX:
        moving = dynamics.motion(self.chain, self._geometry, self._qa, self._va)
        return inertial_coupling.matrix(self.specification, self.chain, self._values, moving, self._va)

    @cached_property
    def _mass_matrix(self) -> ca.SX:
        M_a = dynamics.inertia_matrix(self.chain, self._geometry, self._qa) + ca.diag(
            ca.vertcat(*self._transmission.armature)
        )
        if not self.chain.flexible_motors:
            return M_a
        S = (
            self._coupling
            if self.specification.inertial_coupling
            else ca.SX.zeros(self.n_arm, len(self.chain.flexible_motors))
        )
        return ca.vertcat(ca.horzcat(M_a, S), ca.horzcat(S.T, ca.diag(self._motor_inertia)))

    @cached_property
    def _force(self) -> ca.SX:
        torque = dynamics.inverse_dynamics(
            self.chain, self._geometry, self._gravity, self._qa, self._va, ca.SX.zeros(self.n_arm), self._w
        )
        arm = self._transmission.arm + self._transmission.drive @ self._u - torque
        motor = self._transmission.motor + self._flexible_torque
        force = ca.vertcat(arm, motor)
        if self.specification.inertial_coupling and self.chain.flexible_motors:
            force = force - inertial_coupling.velocity_force(self._coupling, self._qa, self._va, self._v[self.n_arm :])
        return force

    @property
    def _flexible_torque(self) -> ca.SX:
        return ca.vertcat(*[self._u[number] for number in self.chain.flexible_motors])

    @cached_property
    def _acceleration(self) -> ca.SX:
        return self._accelerated_by(ca.SX.zeros(self.n_coordinates))

    def _accelerated_by(self, added: ca.SX, inertia: ca.SX | None = None) -> ca.SX:
        """Return the accelerations under additional forces on the coordinates, with additional inertias of them."""
        heavier = ca.SX(self.n_coordinates, 1) if inertia is None else inertia
        if self.specification.inertial_coupling:
            return inertial_coupling.solve_symmetric(self._mass_matrix + ca.diag(heavier), self._force + added)
        tau = self._transmission.arm + self._transmission.drive @ self._u + added[: self.n_arm]
        armature = [own + heavier[index] for index, own in enumerate(self._transmission.armature)]
        arm = dynamics.forward_dynamics(
            self.chain, self._geometry, self._gravity, armature, self._qa, self._va, tau, self._w
        )
        motor = (
            (self._transmission.motor + self._flexible_torque + added[self.n_arm :])
            / (self._motor_inertia + heavier[self.n_arm :])
            if self.chain.flexible_motors
            else ca.SX(0, 1)
        )
        return ca.vertcat(arm, motor)

    @cached_property
    def acceleration(self) -> ca.Function:
        """Accelerations of q from (q, v, u, w, p)."""
        arguments = [self._q, self._v, self._u, self._w, self._p]
        return self._function("acceleration", arguments, [self._acceleration], ["q", "v", "u", "w", "p"])

    @cached_property
    def forced_acceleration(self) -> ca.Function:
        """Accelerations of q from (q, v, u, w, f, p), with additional forces f on all coordinates."""
        f = ca.SX.sym("f", self.n_coordinates)
        arguments = [self._q, self._v, self._u, self._w, f, self._p]
        return self._function(
            "forced_acceleration", arguments, [self._accelerated_by(f)], ["q", "v", "u", "w", "f", "p"]
        )

    @cached_property
    def heavier_acceleration(self) -> ca.Function:
        """The same from (q, v, u, w, f, e, p), with additional inertias e of all coordinates."""
        f, e = ca.SX.sym("f", self.n_coordinates), ca.SX.sym("e", self.n_coordinates)
        arguments = [self._q, self._v, self._u, self._w, f, e, self._p]
        names = ["q", "v", "u", "w", "f", "e", "p"]
        return self._function("heavier_acceleration", arguments, [self._accelerated_by(f, e)], names)

    @cached_property
    def acceleration_with_mobility(self) -> ca.Function:
        """Accelerations of q, and their derivatives to the motor torques, from (q, v, u, w, f, p)."""
        f = ca.SX.sym("f", self.n_coordinates)
        outputs = self._accelerated_with_mobility(f, self._mass_matrix)
        arguments = [self._q, self._v, self._u, self._w, f, self._p]
        return self._function("acceleration_with_mobility", arguments, outputs, ["q", "v", "u", "w", "f", "p"])

    @cached_property
    def heavier_acceleration_with_mobility(self) -> ca.Function:
        """The same from (q, v, u, w, f, e, p), with additional inertias e of all coordinates."""
        f, e = ca.SX.sym("f", self.n_coordinates), ca.SX.sym("e", self.n_coordinates)
        outputs = self._accelerated_with_mobility(f, self._mass_matrix + ca.diag(e))
        arguments = [self._q, self._v, self._u, self._w, f, e, self._p]
        names = ["q", "v", "u", "w", "f", "e", "p"]
        return self._function("heavier_acceleration_with_mobility", arguments, outputs, names)

    def _accelerated_with_mobility(self, added: ca.SX, mass_matrix: ca.SX) -> list[ca.SX]:
        """Solve for the accelerations and for their derivatives to the motor torques with one factorisation."""
        factors = inertial_coupling.SymmetricFactors.of(mass_matrix)
        drive = ca.jacobian(self._force, self._u)
        return [factors.solve(self._force + added), factors.solve(drive)]

    @cached_property
    def derivative(self) -> ca.Function:
        """State derivative from (x, u, w, p)."""
        x = ca.SX.sym("x", 2 * self.n_coordinates)
        q, v = x[: self.n_coordinates], x[self.n_coordinates :]
        a = ca.substitute(self._acceleration, ca.vertcat(self._q, self._v), ca.vertcat(q, v))
        return self._function("derivative", [x, self._u, self._w, self._p], [ca.vertcat(v, a)], ["x", "u", "w", "p"])

    @cached_property
    def mass_matrix(self) -> ca.Function:
        """Mass matrix of all coordinates from (q, p)."""
        return self._function("mass_matrix", [self._q, self._p], [self._mass_matrix], ["q", "p"])

    @cached_property
    def force(self) -> ca.Function:
        """Generalised force from (q, v, u, w, p), such that mass_matrix @ acceleration = force."""
        arguments = [self._q, self._v, self._u, self._w, self._p]
        return self._function("force", arguments, [self._force], ["q", "v", "u", "w", "p"])

    @cached_property
    def arm_inertia(self) -> ca.Function:
        """Inertia matrix of the arm M_a from (q_a, p)."""
        qa = ca.SX.sym("q_a", self.n_arm)
        return self._function(
            "arm_inertia", [qa, self._p], [dynamics.inertia_matrix(self.chain, self._geometry, qa)], ["q_a", "p"]
        )

    @cached_property
    def arm_inverse_dynamics(self) -> ca.Function:
        """Inverse-dynamics torque M_a a - c - g of the arm from (q_a, v_a, a_a, p)."""
        a = ca.SX.sym("a_a", self.n_arm)
        torque = dynamics.inverse_dynamics(self.chain, self._geometry, self._gravity, self._qa, self._va, a)
        qa, va = ca.SX.sym("q_a", self.n_arm), ca.SX.sym("v_a", self.n_arm)
        torque = ca.substitute(torque, ca.vertcat(self._qa, self._va), ca.vertcat(qa, va))
        return self._function("arm_inverse_dynamics", [qa, va, a, self._p], [torque], ["q_a", "v_a", "a_a", "p"])

    def _split(self, name: str, value: ca.SX) -> ca.Function:
        """Build a function of (q_a, v_a, q_m, v_m, p) with separate motor coordinates."""
        m = self.n_coordinates - self.n_arm
        qa, va = ca.SX.sym("q_a", self.n_arm), ca.SX.sym("v_a", self.n_arm)
        qm, vm = ca.SX.sym("q_m", m), ca.SX.sym("v_m", m)
        old = ca.vertcat(self._q, self._v, self._w, self._u)
        new = ca.vertcat(qa, qm, va, vm, ca.SX.zeros(6 + self.n_motors))
        value = ca.substitute(value, old, new)
        return self._function(name, [qa, va, qm, vm, self._p], [value], ["q_a", "v_a", "q_m", "v_m", "p"])

    @cached_property
    def arm_force(self) -> ca.Function:
        """Right-hand side c + g + tau_a of the arm's equation (Paper B, eq. 2a) from (q_a, v_a, q_m, v_m, p)."""
        zero = ca.SX.zeros(self.n_arm)
        torque = dynamics.inverse_dynamics(self.chain, self._geometry, self._gravity, self._qa, self._va, zero)
        return self._split("arm_force", self._transmission.arm - torque)

    @cached_property
    def transmission_force(self) -> ca.Function:
        """Torque of springs and dampers on the arm, tau_a, from (q_a, v_a, q_m, v_m, p)."""
        return self._split("transmission_force", self._transmission.arm)

    @cached_property
    def motor_force(self) -> ca.Function:
        """Spring, damper and friction torque on the motors, tau_m, from (q_a, v_a, q_m, v_m, p)."""
        return self._split("motor_force", self._transmission.motor)

    @cached_property
    def motor_inertia(self) -> ca.Function:
        """Inertias of the motors behind flexible gears from (p)."""
        return self._function("motor_inertia", [self._p], [self._motor_inertia], ["p"])

    @cached_property
    def encoder(self) -> ca.Function:
        """Motor positions from (q)."""
        return self._function("encoder", [self._q], [self._transmission.encoder], ["q"])

    @cached_property
    def tool_pose(self) -> ca.Function:
        """Tool pose [x y z qx qy qz qw] from (q_a, p)."""
        qa = ca.SX.sym("q_a", self.n_arm)
        pose = kinematics.tool_pose(self.specification, self.chain, self._geometry, qa)
        return self._function("tool_pose", [qa, self._p], [pose], ["q_a", "p"])

    def output(self, name: str | None = None) -> ca.Function:
        """Return the function (q_a, p) -> an output of the robot file, default the controlled one, shape (n_out, 1).

        Raises:
            InputError: The robot has no such output.
        """
        name = name or self.specification.controlled
        if name not in self.specification.outputs:
            raise unknown_name(f"output of robot {self.specification.name}", name, self.specification.outputs)
        if name not in self._outputs:
            qa, entry = ca.SX.sym("q_a", self.n_arm), self.specification.outputs[name]
            value = kinematics.output_value(self.specification, self.chain, self._geometry, entry, qa)
            self._outputs[name] = self._function(f"output_{name}", [qa, self._p], [value], ["q_a", "p"])
        return self._outputs[name]

    def output_with_slope(self, name: str | None = None) -> ca.Function:
        """Controlled output and its Jacobian with respect to the actuated arm coordinates, from (q_a).

        Args:
            name: Name of an output of the robot file; default: the controlled one.

        Returns:
            CasADi function with results of shape (n_out, 1) and (n_out, M), at the nominal parameters.
        """
        name = name or self.specification.controlled
        if name not in self._outputs_with_slope:
            qa = ca.SX.sym("q_a", self.n_arm)
            value = self.output(name)(qa, self.parameter_values)
            slope = ca.jacobian(value, qa)[:, list(self.chain.gear_rows)]
            self._outputs_with_slope[name] = ca.Function(f"slope_{name}", [qa], [value, ca.densify(slope)])
        return self._outputs_with_slope[name]

    def linearised(self, name: str | None = None) -> ca.Function:
        """Blocks of the equations of motion linearised at rest, from (q, v, u), at the nominal parameters.

        Args:
            name: Name of an output of the robot file; default: the controlled one.

        Returns:
            CasADi function with the results mass, damping, stiffness, input, and the slopes of encoders and output.
        """
        name = name or self.specification.controlled
        if name not in self._linearised:
            n = self.n_coordinates
            q, v, u = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("u", self.n_motors)
            p = self.parameter_values
            force = self.force(q, v, u, np.zeros(6), p)
            blocks = [
                self.mass_matrix(q, p),
                -ca.jacobian(force, v),
                -ca.jacobian(force, q),
                ca.jacobian(force, u),
                ca.jacobian(self.encoder(q), q),
                ca.jacobian(self.output(name)(q[: self.n_arm], p), q),
            ]
            dense = [ca.densify(block) for block in blocks]
            self._linearised[name] = ca.Function("linearised", [q, v, u], dense)
        return self._linearised[name]

    @cached_property
    def energy(self) -> ca.Function:
        """Kinetic and potential energy [J] from (q, v, p); gravity and springs are potential."""
        kinetic = ca.bilin(self._mass_matrix, self._v, self._v) / 2
        return self._function("energy", [self._q, self._v, self._p], [kinetic, self._potential()], ["q", "v", "p"])

    def _potential(self) -> ca.SX:
        potential = ca.SX(0)
        position, rotation = ca.SX.zeros(3), ca.SX.eye(3)
        placed = self._geometry.placed(self._q)
        for index, (joint, frame) in enumerate(zip(self.chain.joints, self._geometry.frames)):
            position = position + rotation @ kinematics.joint_origin(self.chain, self._geometry, index, placed[index])
            rotation = rotation @ kinematics.joint_rotation(self.chain, index, placed[index])
            for mass in frame.masses:
                for share, place in _places(mass, self._q):
                    potential = potential - mass.mass * share * ca.dot(self._gravity, position + rotation @ place)
            spring = joint.direction.spring
            if isinstance(spring, Spring):
                deflection = self._q[index]
                if joint.motor_coordinate is not None:
                    deflection = self._q[self.n_arm + joint.motor_coordinate] - deflection
                potential = potential + spring.energy(deflection, self._values[f"{joint.name}.stiffness"])
        return potential


def _places(mass: kinematics.Mass, q: ca.SX) -> list[tuple[float, ca.SX]]:
    """Return shares of a mass and their places in the frame that carries it."""
    return [(point.share, point.at(q)) for point in mass.beam] or [(1.0, mass.center)]
