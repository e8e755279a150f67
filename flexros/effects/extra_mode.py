"""A mode that the model does not have: something on a spring at the tool, or a flexible base."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from flexros.effects.arm_law import AbstractArmLaw
from flexros.effects.ranges import Range
from flexros.robot.kinematics import build_geometry, forward

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.arm_law import ArmState
    from flexros.effects.base import Stage
    from flexros.robot import Robot
    from flexros.robot.kinematics import Value


class ExtraMode(AbstractArmLaw):
    """A mass or an inertia on a spring and a damper, with a frequency of its own.

    With frequency f of the mode alone, w = 2 pi f, damping ratio z, ratio m and a = w^2 e + 2 z w e':

    - At the tool, where the last body has a mass: a point mass of m times that mass on a spring with equal stiffness in
      all directions, displaced by e from the tool point p(q). It moves by e'' + p'' = -a and pulls the arm by
      (dp/dq)^T (m mass a). Its weight is not in it: weigh the load by gravity_error.
    - At the tool, where the last body has an inertia only (models of one axis): the same with an inertia of m times
      that of the last body, turned against the body about the common axis, e'' + (sum of the angles)'' = -a.
    - At the base: the ground of the arm's first direction turns (or slides) about that axis by e, with m times the
      inertia (or mass) of the whole arm about it at home. The arm coordinate then counts from the fixed ground, the
      first spring is deflected by e more, and its torque T on the arm acts back on the base: e'' = -a - T / inertia.
      This is exact for any chain, under gravity too, but for the spin that the turning base gives the rotor. Robots
      whose first direction is rigid have no such place.

    Reference: Two-mass resonator: Moberg 2007, section 3.2 (elastic load and foundation); Den Hartog 1956,
    Mechanical Vibrations, chapter 3.
    """

    name: ClassVar[str] = "extra_mode"
    stage: ClassVar[Stage] = "structure"
    size: ClassVar[str] = "ratio"
    smooth_states: ClassVar[int] = 6
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "frequency": Range("frequency", 2.0, 120.0, 25, source="facts on modes; ratio of starts below 1.18"),
            "ratio": Range("relative", 1e-3, 10.0, 2),
            "damping": Range("relative", 1e-3, 0.5, 1, source="2 to 4 % seen on robots; bounds chosen"),
        }
    )
    fingerprint: ClassVar[str] = (
        "one more pole and zero, at the same frequency in the responses of all joints, without dependence on "
        "amplitude: a common ringing after every jerk"
    )

    frequency: float = Field(10.0, gt=0.0, description="of the mode alone, its ground held still [Hz]")
    ratio: float = Field(0.0, ge=0.0, description="its mass or inertia, relative to the last body's or the arm's [1]")
    damping: float = Field(0.02, ge=0.0, lt=1.0, description="damping ratio of the mode alone [1]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the tool, and the base where the first direction has a spring."""
        first, last = robot.chain.joints[0], robot.chain.joints[-1]
        axes = {(joint.rotary, joint.axis) for joint in robot.chain.joints}
        tool = ("tool",) if _load_mass(robot) > 0 or axes == {(last.rotary, last.axis)} else ()
        rigid = first.motor is not None and first.motor_coordinate is None
        return tool if rigid else (*tool, "base")

    def force(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Pull the tool, or shift the deflection of the first spring."""
        if arm.location == "base":
            return _spring_forces(arm, shifted=True) - _spring_forces(arm, shifted=False)
        place, size = _attachment(arm)
        pull = values["ratio"] * size * _acceleration(arm, values, place)
        return ca.jtimes(place, arm.position, pull, True)

    def rates(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Move the mass, or the base."""
        if arm.location == "base":
            w = 2 * math.pi * values["frequency"]
            pull = w * w * arm.own[0] + 2 * values["damping"] * w * arm.own[1]
            inertia = values["ratio"] * _arm_inertia(arm)
            return ca.vertcat(arm.own[1], -pull - _spring_forces(arm, shifted=True)[0] / inertia, ca.SX.zeros(4))
        place, _ = _attachment(arm)
        n = place.numel()
        relative = arm.own[3 : 3 + n] - ca.jtimes(place, arm.position, arm.speed)
        rest = ca.SX.zeros(3 - n)
        return ca.vertcat(relative, rest, -_acceleration(arm, values, place), rest)

    def rest(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Start with the base turned by the weight of the arm."""
        own = ca.SX.zeros(self.smooth_states)
        if arm.location == "base":
            still = ca.SX.zeros(arm.robot.n_arm)
            needed = arm.model.arm_inverse_dynamics(arm.position, still, still, arm.parameters)[0]
            w = 2 * math.pi * values["frequency"]
            own[0] = -needed / (values["ratio"] * _arm_inertia(arm) * w * w)
        return own


def _load_mass(robot: Robot) -> float:
    """Mass of the last body that has a place in space [kg]; zero for models without geometry."""
    return 0.0 if robot.spec.tool.linear else robot.spec.bodies[-1].mass.value


def _attachment(arm: ArmState) -> tuple[ca.SX, Value]:
    """Give the coordinates to which the mode is attached, and the mass or inertia that the ratio multiplies."""
    last = f"body_{len(arm.robot.spec.bodies)}"
    if _load_mass(arm.robot) > 0:
        geometry = build_geometry(arm.robot.spec, arm.robot.chain, arm.number)
        return forward(arm.robot.chain, geometry, arm.position)[0], arm.number(f"{last}.mass")
    joint = arm.robot.chain.joints[-1]
    if not joint.rotary:
        return ca.sum1(arm.position), arm.number(f"{last}.mass")
    return ca.sum1(arm.position), arm.number(f"{last}.inertia.{'xyz'[joint.axis] * 2}")


def _acceleration(arm: ArmState, values: Mapping[str, Value], place: ca.SX) -> ca.SX:
    """Acceleration a of the tool against the mode, by spring and damper."""
    n = place.numel()
    w = 2 * math.pi * values["frequency"]
    relative = arm.own[3 : 3 + n] - ca.jtimes(place, arm.position, arm.speed)
    return w * w * arm.own[:n] + 2 * values["damping"] * w * relative


def _arm_inertia(arm: ArmState) -> ca.SX:
    """Inertia or mass of the whole arm about its first direction, at home."""
    home = np.asarray(arm.robot.home)
    return arm.model.arm_inertia(home, arm.parameters)[0, 0]


def _spring_forces(arm: ArmState, *, shifted: bool) -> ca.SX:
    """Torques of springs and dampers on all coordinates, with the first arm coordinate against ground or base."""
    position, speed = ca.SX(arm.position), ca.SX(arm.speed)
    if shifted:
        position[0] -= arm.own[0]
        speed[0] -= arm.own[1]
    arguments = (position, speed, arm.motor_position, arm.motor_speed, arm.parameters)
    return ca.vertcat(arm.model.transmission_force(*arguments), arm.model.motor_force(*arguments))
