"""The simplified flexible-joint model of a robot, and its flatness (Moberg 2007, section 5.3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import casadi

from flexros.errors import InputError
from flexros.robot.spring import Spring
from flexros.robot.symbolic.inertial_coupling import solve_symmetric

if TYPE_CHECKING:
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class LinkStates:
    """Position of the links and its derivatives, the states of equation 5.6, SX (N, 1) each [rad or m, per s^k]."""

    position: casadi.SX
    velocity: casadi.SX
    acceleration: casadi.SX
    jerk: casadi.SX


@dataclass(frozen=True, eq=False)
class GearMotion:
    """Deflection of the gears q_m - q_a that moves the links, and its first two derivatives, SX (N, 1) each."""

    deflection: casadi.SX
    rate: casadi.SX
    acceleration: casadi.SX


class FlexibleJointModel:
    """M_a q_a'' + n(q_a, q_a') = f(q_m - q_a),  M_m q_m'' = u - f(q_m - q_a) - f_m q_m'   (equations 5.4).

    The springs f may be nonlinear; n contains gravity, velocity terms and the friction of the bodies. As in the text,
    the gears have no dampers, and links and motors are not coupled by inertia.

    Args:
        robot: The robot.

    Raises:
        InputError: A direction has no motor, a gear is rigid or its spring cannot be inverted, or the robot couples
            links and motors by inertia.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._check()
        laws = [robot.joints[row].direction.spring for row in robot.gear_rows]
        self._springs = [law for law in laws if isinstance(law, Spring)]
        self._scales = [robot.parameters[f"{robot.joints[row].name}.stiffness"].value for row in robot.gear_rows]
        self._q, self._v, self._a, self._j, self._s = (casadi.SX.sym(name, robot.n_arm) for name in "qvajs")

    def _check(self) -> None:
        robot = self.robot
        passive = [joint.name for joint in robot.joints if joint.motor is None]
        stiff = [robot.joint_names[motor] for motor in robot.stiff_motors]
        for found, what in ((passive, "directions without motor"), (stiff, "motors behind rigid gears")):
            if found:
                raise InputError(
                    f"the flexible-joint model needs a motor behind a spring in every direction, but {robot.name} "
                    f"has {what}: {', '.join(found)}; choose a robot of flexible joints, such as elbow, or another law"
                )
        if robot.spec.inertial_coupling:
            raise InputError(
                f"the flexible-joint model has no inertial coupling of links and motors (Moberg 2007, equation 3.11), "
                f"but robot {robot.name} has; set inertial_coupling: false for the controller's robot"
            )
        for row in robot.gear_rows:
            spring = robot.joints[row].direction.spring
            assert isinstance(spring, Spring)
            try:
                spring.deflection(casadi.SX(0), 1.0)
            except ValueError as error:
                raise InputError(f"robot {robot.name}, {robot.joints[row].name}: {error}; give it stiffness") from error

    def load(self, position: casadi.SX, velocity: casadi.SX, acceleration: casadi.SX) -> casadi.SX:
        """Return the torque that moves the links, M_a q_a'' + n [Nm or N], SX (N, 1)."""
        model = self.robot.model
        return model.arm_inverse_dynamics(position, velocity, acceleration, model.parameter_values)

    def spring_torque(self, deflection: casadi.SX) -> casadi.SX:
        """Return the torques f of the springs [Nm or N], SX (N, 1)."""
        laws = zip(self._springs, self._scales, casadi.vertsplit(deflection))
        return casadi.vertcat(*[spring.force(part, scale) for spring, scale, part in laws])

    def measured_links(
        self, motor: casadi.SX, motor_velocity: casadi.SX, link: casadi.SX, link_velocity: casadi.SX
    ) -> LinkStates:
        """Return the states of the links by the model, from positions and speeds of motors and links.

        q_a'' = M_a^-1 (f(d) - n),  q_a''' = M_a^-1 (f'(d) d' - M_a' q_a'' - n'),  d = q_m - q_a
        """
        q, v, a = self._q, self._v, self._a
        rest = self.load(q, v, 0 * a)
        rate = casadi.jtimes(self.load(q, v, a), q, v) + casadi.jtimes(self.load(q, v, a), v, a)
        inertia = self.robot.model.arm_inertia(link, self.robot.model.parameter_values)
        torque = self.spring_torque(motor - link)
        acceleration = solve_symmetric(inertia, torque - casadi.substitute([rest], [q, v], [link, link_velocity])[0])
        known = casadi.substitute([rate], [q, v, a], [link, link_velocity, acceleration])[0]
        torque_rate = self._slope(motor - link) * (motor_velocity - link_velocity)
        return LinkStates(link, link_velocity, acceleration, solve_symmetric(inertia, torque_rate - known))

    def gear_motion(self, links: LinkStates, snap: casadi.SX, measured: GearMotion | None = None) -> GearMotion:
        """Return the deflection that moves the links with a fourth derivative, by two differentiations of (5.4a).

        d'' = (tau'' - f''(d) d'^2) / f'(d) with tau = M_a q_a'' + n. The slopes of the springs are taken at a measured
        deflection if there is one, else at f^-1(tau).

        Args:
            links: States of the links.
            snap: Fourth derivative of their positions, SX (N, 1).
            measured: Measured deflection and rate; its acceleration is not used.
        """
        torque, rate, second = self._torque_derivatives(links, snap)
        if measured is None:
            laws = zip(self._springs, self._scales, casadi.vertsplit(torque))
            deflection = casadi.vertcat(*[spring.deflection(part, scale) for spring, scale, part in laws])
            speed = rate / self._slope(deflection)
        else:
            deflection, speed = measured.deflection, measured.rate
        bend = self._curvature(deflection) * speed**2
        return GearMotion(deflection, speed, (second - bend) / self._slope(deflection))

    def motor_torque(
        self, gear_torque: casadi.SX, motor_velocity: casadi.SX, motor_acceleration: casadi.SX
    ) -> casadi.SX:
        """Return the torque that accelerates the motors against their gears, by (5.4b) [Nm or N], SX (M, 1)."""
        robot, parameters = self.robot, self.robot.parameters
        friction = casadi.DM([parameters[f"{name}.viscous_friction"].value for name in robot.joint_names])
        inertia = robot.model.motor_inertia(robot.model.parameter_values)
        return gear_torque + friction * motor_velocity + inertia * motor_acceleration

    def damping(self) -> casadi.DM:
        """Return the dampers of the gears, which the model of the links neglects [Nm s/rad or N s/m], DM (M, 1)."""
        names = [self.robot.joints[row].name for row in self.robot.gear_rows]
        return casadi.DM([self.robot.parameters[f"{name}.damping"].value for name in names])

    def _torque_derivatives(self, links: LinkStates, snap: casadi.SX) -> tuple[casadi.SX, casadi.SX, casadi.SX]:
        chain = (self._q, self._v, self._a, self._j, self._s)
        torque = self.load(*chain[:3])
        found = [torque]
        for order in range(3, 5):
            last = found[-1]
            parts = [casadi.jtimes(last, low, high) for low, high in pairwise(chain[: order + 1])]
            found.append(sum(parts[1:], start=parts[0]))
        given = [links.position, links.velocity, links.acceleration, links.jerk, snap]
        torque, rate, second = casadi.substitute(found, list(chain), given)
        return torque, rate, second

    def _slope(self, deflection: casadi.SX) -> casadi.SX:
        """Return the stiffness f' at a deflection, SX (N, 1)."""
        d = casadi.SX.sym("d", deflection.numel())
        slope = casadi.jtimes(self.spring_torque(d), d, casadi.SX.ones(d.numel()))
        return casadi.densify(casadi.substitute([slope], [d], [deflection])[0])

    def _curvature(self, deflection: casadi.SX) -> casadi.SX:
        d = casadi.SX.sym("d", deflection.numel())
        bend = casadi.jtimes(self._slope(d), d, casadi.SX.ones(d.numel()))
        return casadi.densify(casadi.substitute([bend], [d], [deflection])[0])
