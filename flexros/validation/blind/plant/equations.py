"""Equations of motion of a blind plant while deviations are put into them.

They share with the rest of FlexROS the rigid-body mass matrix and force of the robot alone. The accelerations come from
a factorisation of the whole mass matrix, and every deviation is an equation of its own, with another law or another
regularisation than the effect of the same name in `flexros.effects`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import casadi as ca

from flexros.robot.spring import Spring
from flexros.robot.symbolic.inertial_coupling import solve_symmetric

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.symbolic.chain import Joint


@dataclass(frozen=True)
class InnerState:
    """A state that a deviation adds.

    Attributes:
        symbol: The state, SX scalar.
        rate: Its derivative; integrated with the robot.
        update: Its value after a time h, from the symbol `Equations.step`; for what is too stiff or not smooth.
        start: Value before the first sample.
    """

    symbol: ca.SX
    rate: ca.SX | None = None
    update: ca.SX | None = None
    start: float = 0.0


@dataclass
class Twist:
    """Deflection of a gear, as the spring between motor and arm sees it.

    Attributes:
        angle: Deflection [rad].
        rate: Its rate [rad/s].
        lever: Deflection per way of the motor [1], by which the motor feels the torque of the gear.
    """

    angle: ca.SX
    rate: ca.SX
    lever: ca.SX | float = 1.0


@dataclass
class Equations:
    """Symbols of one plant and what deviations change.

    Attributes:
        robot: The robot; with a further body where a mode was added.
        load_body: Number of the last body in the robot file, which is the load.
        tick: Time of an integration step [s].
        first_body: 1 where a body was put under the robot's first one, so that its names count from the second.
        q: Coordinates [q_a, q_m].
        v: Their rates.
        command: Torque that arrives at each motor, delays included, SX (M, 1).
        push: Signal from outside, e.g. of pushes at the tool, SX scalar.
        time: Time since the start of the log [s], SX scalar.
        step: Time h of an `InnerState.update` [s].
        torque: Torque of each motor after its drive, length M.
        added: Generalised force in addition to that of the robot, length n_coordinates.
        armature: Inertia in addition to that of the robot, length n_coordinates.
        factors: Factors on numbers of the robot by name.
        twists: Changed deflections of gears, by motor.
        states: States of deviations.
        delays: Delay of each motor's command in addition to the robot's own [s], length M.
        readings: What each encoder makes of the motor position, one after the other, by motor.
    """

    robot: Robot
    load_body: int
    tick: float
    first_body: int = 0
    factors: dict[str, ca.SX] = field(default_factory=dict)
    twists: dict[int, Twist] = field(default_factory=dict)
    states: list[InnerState] = field(default_factory=list)
    readings: dict[int, list[Callable[[ca.SX], ca.SX]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Make the symbols."""
        n, m = self.robot.n_coordinates, self.robot.n_motors
        self.q, self.v = ca.SX.sym("q", n), ca.SX.sym("v", n)
        self.command, self.push = ca.SX.sym("u", m), ca.SX.sym("push")
        self.wrench = ca.SX.sym("w", 6)
        self.time, self.step = ca.SX.sym("t"), ca.SX.sym("h")
        self.torque: list[ca.SX] = [self.command[motor] for motor in range(m)]
        self.added: list[ca.SX] = [ca.SX(0)] * n
        self.armature: list[ca.SX] = [ca.SX(0)] * n
        self.delays: list[ca.SX] = [ca.SX(0)] * m

    def motors(self, location: str) -> tuple[int, ...]:
        """Return the motors of a location, a joint name or "all"."""
        if location == "all":
            return tuple(range(self.robot.n_motors))
        return (self.robot.joint_names.index(location),)

    def place(self, motor: int) -> int:
        """Return the index of a motor's position among the coordinates."""
        return self.robot.motor_rows[motor]

    def angle(self, motor: int) -> ca.SX:
        """Return the angle of a rotor [rad]: gear ratio times coordinate on a robot stated on the arm side."""
        turns = self.robot.motors[motor].gear_ratio if self.robot.spec.coordinates == "arm" else 1.0
        return turns * self.q[self.place(motor)]

    def joint(self, name: str) -> int:
        """Find an arm coordinate by the name it has in the robot file."""
        body, _, axis = name.partition(".")
        number = int(body.removeprefix("body_")) + self.first_body
        return [joint.name for joint in self.robot.joints].index(f"body_{number}.{axis}")

    def scale(self, name: str, factor: ca.SX) -> None:
        """Multiply a number of the robot, named as in the robot file."""
        body, _, rest = name.partition(".")
        if body.startswith("body_"):
            name = f"body_{int(body.removeprefix('body_')) + self.first_body}.{rest}"
        self.factors[name] = self.factors.get(name, ca.SX(1)) * factor

    def deflection(self, joint: int) -> Twist:
        """Return the deflection of a joint's spring and its rate: of a gear from arm to motor, else of the arm."""
        joint_spec = self.robot.joints[joint]
        if joint_spec.motor_coordinate is None:
            return Twist(self.q[joint], self.v[joint])
        own = self.robot.n_arm + joint_spec.motor_coordinate
        return Twist(self.q[own] - self.q[joint], self.v[own] - self.v[joint])

    def twist(self, motor: int) -> Twist:
        """Return the deflection of a gear with what deviations have made of it so far."""
        return self.twists.get(motor) or self.deflection(self.robot.gear_rows[motor])

    def gear_torque(self, joint: int, twist: Twist) -> ca.SX:
        """Evaluate spring and damper of a joint [Nm or N] at a deflection."""
        return self.spring_torque(joint, twist.angle) + self.number(joint, "damping") * twist.rate

    def spring_torque(self, joint: int, angle: ca.SX) -> ca.SX:
        """Evaluate the spring of a joint [Nm or N] at a deflection."""
        spring = self.robot.joints[joint].direction.spring
        assert isinstance(spring, Spring)
        return spring.force(angle, self.number(joint, "stiffness"))

    def number(self, joint: int, kind: str) -> ca.SX:
        """Return stiffness or damping of a joint with its factor."""
        name = f"{self.robot.joints[joint].name}.{kind}"
        return self.robot.parameters[name].value * self.factors.get(name, ca.SX(1))

    def add_spring_torque(self, joint: int, torque: ca.SX) -> None:
        """Add a torque that acts against the deflection of a joint, on arm and motor."""
        found: Joint = self.robot.joints[joint]
        if found.motor_coordinate is None:
            self.added[joint] -= torque
            return
        self.added[self.robot.n_arm + found.motor_coordinate] -= torque
        self.added[joint] += torque

    def add_torque(self, motor: int, torque: ca.SX) -> None:
        """Add a torque at a motor."""
        self.added[self.place(motor)] += torque

    def starts(self) -> FloatArray:
        """Return the start values of all added states, shape (number of them,)."""
        import numpy as np

        return np.array([state.start for state in self.states])

    def acceleration(self) -> ca.SX:
        """Solve the equations of motion for the accelerations, SX (n_coordinates, 1)."""
        for motor, twist in self.twists.items():
            joint = self.robot.gear_rows[motor]
            torque = self.gear_torque(joint, twist)
            self.add_spring_torque(joint, torque - self.gear_torque(joint, self.deflection(joint)))
            self.add_torque(motor, (1 - twist.lever) * torque)
        names = tuple(self.factors)
        model = self.robot.symbolic(names)
        values = ca.vertcat(
            ca.SX(0, 1),
            *[value * self.factors[name] for name, value in zip(names, model.parameter_values, strict=True)],
        )
        mass = model.mass_matrix(self.q, values) + ca.diag(ca.vertcat(*self.armature))
        force = model.force(self.q, self.v, ca.vertcat(*self.torque), self.wrench, values)
        return solve_symmetric(ca.densify(mass), force + ca.vertcat(*self.added))
