"""Spring whose stiffness changes at a knee."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from flexros.config.settings import validate
from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.model_change import AbstractModelChange
from flexros.effects.kinds.ranges import Range
from flexros.errors import InputError
from flexros.robot import Robot
from flexros.robot.specification import RobotSpecification
from flexros.robot.spring import PiecewiseLinear, Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.gear_law import GearState, GearTorques
    from flexros.robot.symbolic.kinematics import Value

CORNER = (-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0)
"""Knots of the polygon that approximates a rounded corner in a robot file, in widths from the knee [1] (chosen)."""


class NonlinearStiffness(AbstractModelChange, AbstractGearLaw):
    """A spring of nominal stiffness up to a knee and of another one beyond: hardening or softening.

    With stiffness k, deflection d, knee c and relative change r the torque of the spring is

        k d                                     for |d| <= c,
        sign(d) (k c + (1 + r) k (|d| - c))     beyond: odd, continuous, with a corner at the knee.

    Real springs bend gradually: with a rounding s the stiffness changes linearly with the deflection from (1 - s) c to
    (1 + s) c, and is nominal before: r k (g(|d|) - g(0)) is added, with g(x) = (x - c + s c)^2 / (4 s c) between these
    two, 0 before and x - c beyond. A spring that is already piecewise linear has its stiffness scaled by 1 + r beyond
    the knee, with g applied to its torque. The knee is given as a deflection or as its torque k c. The effect acts
    between motor and arm for a gear, on the arm coordinate for the other springs. The damper is unchanged.

    A simulated robot has the changed spring in its specification, so that its rest, energy and linearisation include it
    (a rounded corner as a polygon). With free parameters, as in a diagnosis, the same torques are a law parallel to the
    nominal spring.

    Reference: Piecewise stiffness K1, K2, K3 of gear catalogues; Moberg 2007, Paper C, section 3.1 (nonlinear gear
    elasticity).
    """

    name: ClassVar[str] = "nonlinear_stiffness"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "relative"
    rank: ClassVar[int] = 1
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "relative": Range(
                "relative",
                0.01,
                10.0,
                6,
                signed=True,
                source="catalogues: K3/K1 of 1.3 to 2; bounds chosen",
                negative=0.95,
            ),
            "knee": Range(
                "deflection",
                0.01,
                1.0,
                4,
                source="chosen: from small motion to the largest deflection",
                vanishes="never",
            ),
            "rounding": Range(
                "relative", 0.01, 2.0, 1, source="chosen: from a corner to a gradual bend", vanishes="never"
            ),
        }
    )
    signatures: ClassVar[tuple[str, ...]] = (
        "torsion_over_torque",
        "frequency_response",
        "torque_over_position",
        "detection_lines",
    )
    fingerprint: ClassVar[str] = (
        "resonance and antiresonance shift with amplitude and static load, without loss of energy; odd "
        "harmonics, under load also even ones"
    )

    relative: float = Field(0.0, gt=-1.0, le=100.0, description="change of stiffness beyond the knee [1]; > 0 hardens")
    knee: float = Field(0.0, ge=0.0, description="deflection at the knee [rad or m]; 0: knee_torque is given instead")
    knee_torque: float = Field(0.0, ge=0.0, description="torque at the knee [Nm or N]; 0: knee is given instead")
    rounding: float = Field(0.0, ge=0.0, le=10.0, description="width of the corner over the knee [1]; 0: sharp")

    @model_validator(mode="after")
    def _one_knee(self) -> NonlinearStiffness:
        if (self.relative != 0 or self.knee * self.knee_torque > 0) and (self.knee > 0) == (self.knee_torque > 0):
            raise ValueError(
                f"knee is {self.knee:g} and knee_torque {self.knee_torque:g}, but one of the two must be above zero "
                "and the other omitted: give knee=... [rad or m] or knee_torque=... [Nm or N]"
            )
        return self

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the springs that are linear or piecewise linear, with a stiffness above zero."""
        springs = {joint.name: joint.direction.spring for joint in robot.joints}
        return tuple(
            name
            for name, spring in springs.items()
            if isinstance(spring, Spring)
            and spring.cubic is None
            and (spring.stiffness is None or spring.stiffness.value)
        )

    def changed(self, robot: Robot, location: str) -> Robot:
        """Return the robot with the knee in the law of the spring."""
        if self.relative == 0:
            return robot
        data = robot.spec.model_dump()
        *way, last = robot.parameters[f"{location}.stiffness"].path
        here: Any = data
        for part in way:
            here = here[part]
        spring = next(joint.direction.spring for joint in robot.joints if joint.name == location)
        assert isinstance(spring, Spring)
        here[last] = {"piecewise_linear": self._law(spring, location)}
        return Robot(validate(RobotSpecification, data, self.name), self.name, robot.commands)

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Return the additional torque beyond the knee."""
        return gear.transmits(self._more(gear, gear.deflection, values))

    def onward(self, gear: GearState, values: Mapping[str, Value]) -> GearState:
        """Pass the changed spring."""
        return replace(
            gear,
            torque=gear.torque + self._more(gear, gear.deflection, values),
            spring=lambda deflection: gear.spring(deflection) + self._more(gear, deflection, values),
        )

    def _more(self, gear: GearState, deflection: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the torque in addition to that of the spring without knee."""
        at_knee = ca.SX(values["knee_torque"]) if self.knee_torque else gear.spring(ca.SX(values["knee"]))
        torque = gear.spring(deflection)
        more: ca.SX = _beyond(ca.fabs(torque), at_knee, values["rounding"])
        return values["relative"] * ca.sign(torque) * more

    def _law(self, spring: Spring, location: str) -> dict[str, Any]:
        """Return knots and slopes including the knee."""
        law, stiffness = spring.piecewise_linear, spring.stiffness
        if law is None:
            assert stiffness is not None
            knee, k = self.knee or self.knee_torque / stiffness.value, stiffness.value
            law = PiecewiseLinear(knots=(knee,), slopes=(k, k), source=stiffness.source, tolerance=stiffness.tolerance)
        at_knee = self.knee_torque or _torque(law, self.knee)
        bends = {self.knee or _deflection(law, at_knee, f"{self.name} at {location}")}
        if self.rounding:
            most = _torque(law, law.knots[-1]) if law.slopes[-1] == 0 else np.inf
            corner = [at_knee * (1 + self.rounding * width) for width in CORNER]
            bends |= {_deflection(law, torque, self.name) for torque in corner if 0 < torque < most}
        knots = np.array(sorted({*law.knots, *bends}))
        torques = np.array([_torque(law, knot) for knot in (0.0, *knots)])
        more = [float(_beyond(torque, at_knee, self.rounding)) for torque in torques]
        bent = torques + self.relative * np.array(more)
        slopes = [*np.diff(bent) / np.diff([0.0, *knots]), law.slopes[-1] * (1 + self.relative)]
        return {
            "knots": tuple(knots.tolist()),
            "slopes": tuple(map(float, slopes)),
            "source": law.source,
            "tolerance": law.tolerance,
        }


def _beyond(torque: Any, knee: Any, rounding: Any) -> Any:
    """Return by how much a torque is beyond that of a knee, g(torque) - g(0) of a rounded one; a torque >= 0."""
    if not isinstance(rounding, ca.SX) and rounding == 0:
        return ca.fmax(torque - knee, 0)
    width = rounding * knee

    def ramp(beyond: Any) -> Any:
        within = ca.fmin(ca.fmax(beyond, -width), width)
        return (within + width) ** 2 / (4 * width) + ca.fmax(beyond - width, 0)

    return ramp(torque - knee) - ramp(-knee)


def _torque(law: PiecewiseLinear, deflection: float) -> float:
    """Return the torque at a deflection that is not negative."""
    begins = (0.0, *law.knots)
    ends = (*law.knots, float("inf"))
    return sum(slope * max(0.0, min(deflection, end) - begin) for begin, end, slope in zip(begins, ends, law.slopes))


def _deflection(law: PiecewiseLinear, torque: float, source: str) -> float:
    """Return the deflection at which a law reaches a torque."""
    begins, reached = (0.0, *law.knots), 0.0
    for begin, end, slope in zip(begins, (*law.knots, float("inf")), law.slopes):
        if slope > 0 and reached + slope * (end - begin) >= torque:
            return begin + (torque - reached) / slope
        reached += slope * (end - begin) if slope > 0 else 0.0
    raise InputError(f"{source}: knee_torque is {torque:g}, but the spring never reaches it; lower it or give knee")
