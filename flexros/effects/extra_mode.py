"""An unmodelled mode: a mass on a spring at the tool, or a flexible base."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.ranges import Range
from flexros.robot.symbolic.dynamics import motion
from flexros.robot.symbolic.kinematics import build_geometry, forward

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.arm_law import ArmState
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class ExtraMode(AbstractArmLaw):
    """A mass or an inertia on a spring and a damper with its own natural frequency.

    With frequency f of the mode alone, w = 2 pi f, damping ratio z, ratio m and a = w^2 e + 2 z w e':

    - At the tool, where the last body has a mass: a point mass of m times that mass on a spring with equal stiffness in
      all directions, displaced by e from the tool point p(q). It moves by e'' + p'' = -a and exerts the force
      (dp/dq)^T (m mass a) on the arm. Its weight is not included: see gravity_error. With `inertia_ratio` i an inertia
      of i times that of the last body rotates relative to it about the axis of the last rotation, by the same law. Both
      are added to the body: a non-rigid part of a known mass is this effect with a payload_error that removes the mass.
    - At the tool, where the last body has an inertia only (models of one axis): an inertia of m times that one.
    - At the base: the ground of the arm's first direction rotates (or slides) about that axis by e, with m times the
      inertia (or mass) of the whole arm about it at home. The arm coordinate then refers to the fixed ground, the first
      spring is deflected by e more, and its torque T on the arm reacts on the base: e'' = -a - T / inertia. This is
      exact for any chain, also under gravity, except for the rotation of the rotor with the base. Robots whose first
      direction is rigid have no such location.

    Reference: Two-mass resonator: Moberg 2007, section 3.2 (elastic load and foundation); Den Hartog 1956,
    Mechanical Vibrations, chapter 3.
    """

    name: ClassVar[str] = "extra_mode"
    stage: ClassVar[Stage] = "structure"
    size: ClassVar[str] = "ratio"
    further_sizes: ClassVar[tuple[str, ...]] = ("inertia_ratio",)
    smooth_states: ClassVar[int] = 8
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "frequency": Range("frequency", 2.0, 120.0, 25, source="facts on modes; ratio of starts below 1.18"),
            "ratio": Range(
                "relative", 1e-6, 10.0, 3, source="chosen: from no effect; a base from 1e-3, to be integrable"
            ),
            "inertia_ratio": Range("relative", 1e-6, 10.0, 2, source="chosen: from no effect"),
            "damping": Range("relative", 1e-3, 0.5, 1, source="2 to 4 % seen on robots; bounds chosen"),
        }
    )
    signatures: ClassVar[tuple[str, ...]] = ("frequency_response", "detection_lines", "tool_error")
    fingerprint: ClassVar[str] = (
        "an additional pole and zero at the same frequency in the responses of all joints, independent of amplitude: "
        "a common ringing after every jerk"
    )

    frequency: float = Field(10.0, gt=0.0, description="of the mode alone, its ground held still [Hz]")
    ratio: float = Field(0.0, ge=0.0, description="its mass or inertia, relative to the last body's or the arm's [1]")
    inertia_ratio: float = Field(
        0.0, ge=0.0, description="inertia that turns at a tool with a mass, relative to the last body's [1]"
    )
    damping: float = Field(0.02, ge=0.0, lt=1.0, description="damping ratio of the mode alone [1]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the tool, and the base if the first direction has a spring."""
        first, last = robot.joints[0], robot.joints[-1]
        axes = {(joint.rotary, joint.axis) for joint in robot.joints}
        alike = axes == {(last.rotary, last.axis)} and not robot.chain.turned
        tool = ("tool",) if _load_mass(robot) > 0 or alike else ()
        rigid = first.motor is not None and first.motor_coordinate is None
        return tool if rigid else (*tool, "base")

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the ranges; only a tool with a mass also has a rotating inertia, and a base is not very light.

        The ground of an arm moves the less the heavier it is, a part that swings at the tool the lighter.
        """
        both = location == "tool" and _load_mass(robot) > 0 and _turning(robot) is not None
        ranges = {name: allowed for name, allowed in self.ranges.items() if both or name != "inertia_ratio"}
        if location == "base":
            ranges["ratio"] = replace(ranges["ratio"], low=1e-3, vanishes="high")
        return ranges

    def force(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the force on the tool, or that of the shifted deflection of the first spring."""
        if arm.location == "base":
            return _spring_forces(arm, shifted=True) - _spring_forces(arm, shifted=False)
        force = ca.SX.zeros(arm.robot.n_arm)
        for part in _parts(arm, values):
            force += ca.jtimes(part.rate, arm.speed, part.size * _acceleration(arm, values, part), True)
        return force

    def rates(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the rates of mass or base."""
        rates = ca.SX.zeros(self.smooth_states)
        if arm.location == "base":
            w = 2 * math.pi * values["frequency"]
            pull = w * w * arm.own[0] + 2 * values["damping"] * w * arm.own[1]
            inertia = values["ratio"] * _arm_inertia(arm)
            rates[0], rates[1] = arm.own[1], -pull - _spring_forces(arm, shifted=True)[0] / inertia
            return rates
        for part in _parts(arm, values):
            rates[part.displacement] = arm.own[part.speed] - part.rate
            rates[part.speed] = -_acceleration(arm, values, part)
        return rates

    def rest(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the mass moving with the tool, or the base deflected by the weight of the arm."""
        own = ca.SX.zeros(self.smooth_states)
        if arm.location == "base":
            still = ca.SX.zeros(arm.robot.n_arm)
            needed = arm.model.arm_inverse_dynamics(arm.position, still, still, arm.parameters)[0]
            w = 2 * math.pi * values["frequency"]
            own[0] = -needed / (values["ratio"] * _arm_inertia(arm) * w * w)
            return own
        for part in _parts(arm, values):
            own[part.speed] = part.rate
        return own


@dataclass(frozen=True)
class _Part:
    """A mass or inertia on a spring at the tool.

    Attributes:
        rate: Speed of its attachment, linear in that of the arm [m/s or rad/s], SX (n, 1).
        size: Its mass or inertia [kg or kg m2].
        displacement: Its displacements among the own states.
        speed: Its own speeds among the own states.
    """

    rate: ca.SX
    size: Value
    displacement: slice
    speed: slice


def _load_mass(robot: Robot) -> float:
    """Return the mass of the last body [kg]; zero for models without geometry."""
    return 0.0 if robot.spec.tool.linear else robot.spec.bodies[-1].mass.value


def _turning(robot: Robot) -> int | None:
    """Return the index of the axis of the last rotation; None if the last body has no inertia about it."""
    axes = [joint.axis for joint in robot.joints if joint.rotary]
    tensor = robot.spec.bodies[-1].inertia.matrix()
    return axes[-1] if axes and tensor[axes[-1], axes[-1]] > 0 else None


def _parts(arm: ArmState, values: Mapping[str, Value]) -> list[_Part]:
    """Return the masses and inertias at the tool."""
    last, chain = f"body_{len(arm.robot.spec.bodies)}", arm.robot.chain
    geometry = build_geometry(arm.robot.spec, chain, arm.parameter)
    axis, parts = _turning(arm.robot), []
    heavy = _load_mass(arm.robot) > 0
    if heavy:
        rate = ca.jtimes(forward(chain, geometry, arm.position)[0], arm.position, arm.speed)
        parts.append(_Part(rate, values["ratio"] * arm.parameter(f"{last}.mass"), slice(0, 3), slice(4, 7)))
    elif axis is None:
        rate = ca.sum1(arm.speed)
        parts.append(_Part(rate, values["ratio"] * arm.parameter(f"{last}.mass"), slice(0, 1), slice(4, 5)))
    if axis is not None:
        rate = motion(chain, geometry, arm.position, arm.speed).angular[-1][axis]
        inertia = arm.parameter(f"{last}.inertia.{'xyz'[axis] * 2}")
        ratio = values["inertia_ratio" if heavy else "ratio"]
        parts.append(_Part(rate, ratio * inertia, slice(3, 4), slice(7, 8)))
    return parts


def _acceleration(arm: ArmState, values: Mapping[str, Value], part: _Part) -> ca.SX:
    """Return the relative acceleration a by spring and damper."""
    w = 2 * math.pi * values["frequency"]
    return w * w * arm.own[part.displacement] + 2 * values["damping"] * w * (arm.own[part.speed] - part.rate)


def _arm_inertia(arm: ArmState) -> ca.SX:
    """Return the inertia or mass of the whole arm about its first direction at home."""
    home = np.asarray(arm.robot.home)
    return arm.model.arm_inertia(home, arm.parameters)[0, 0]


def _spring_forces(arm: ArmState, *, shifted: bool) -> ca.SX:
    """Return the forces of springs and dampers on all coordinates, the first relative to ground or to base."""
    position, speed = ca.SX(arm.position), ca.SX(arm.speed)
    if shifted:
        position[0] -= arm.own[0]
        speed[0] -= arm.own[1]
    arguments = (position, speed, arm.motor_position, arm.motor_speed, arm.parameters)
    return ca.vertcat(arm.model.transmission_force(*arguments), arm.model.motor_force(*arguments))
