"""Hysteresis of a gear."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.gear_law import GearState, GearTorques
    from flexros.robot.symbolic.kinematics import Value


NODES = (0.3214, 0.9425, 1.4137, 1.9529, 2.6888, 4.2352)
"""Slip angles of elements of equal level whose sum approximates 1 - exp(-x), relative to the transition angle: the
level density x exp(-x) of that curve divided into equal parts, each with its own mean stiffness."""


class Hysteresis(AbstractGearLaw):
    """Rate-independent friction inside the gear, parallel to its spring: Maxwell-slip elements.

    Element i of n = 6 has the stiffness k_i, the level F/n and slips at the angle w_i = F / (n k_i). With deflection d
    and the position z_i of its slider the additional torque is

        sum of k_i clip(d - z_i, -w_i, w_i),    and z_i follows d at the distance w_i once it is reached.

    All elements together have the level F and at a reversal the stiffness F / a, with a the transition angle. The
    angles w_i spread as a times a node to the power of `spread`: at 0 all elements slip together at a (an element of
    Prandtl), at 1 the first loading is F (1 - exp(-d / a)), the curve of Dahl and of Bouc-Wen with exponent 1, and
    more spreads further. A loop of large amplitude D has the area 4 F (D - mean of the w_i).

    Laws of Dahl and of Bouc-Wen with a transition length L have the stiffness F / L at the first loading, but 2 F / L
    at a reversal from full slip, where these elements have F / a at both: fitted to such a law, a is between L / 2 and
    L.

    Reference: Maxwell-slip: Iwan 1966, J. Applied Mechanics 33; Al-Bender, Lampaert, Swevers 2005, IEEE Trans.
    Automatic Control 50; Bouc-Wen: Wen 1976, J. Engineering Mechanics 102.
    """

    name: ClassVar[str] = "hysteresis"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "level"
    rank: ClassVar[int] = 3
    stepwise_states: ClassVar[int] = len(NODES)
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "level": Range("torque", 1e-6, 1.0, 4, source="facts on lost motion of gears; bounds chosen"),
            "angle": Range("deflection", 1e-3, 2.0, 4, source="chosen: from small loops to the largest deflection"),
            "spread": Range("relative", 0.25, 2.0, 1, source="chosen: around the curve of Dahl and Bouc-Wen"),
        }
    )
    shape_doubt: ClassVar[Mapping[str, float]] = MappingProxyType({"spread": 0.5})  # half of its usual range (chosen)
    signatures: ClassVar[tuple[str, ...]] = ("torsion_over_torque", "detection_lines")
    fingerprint: ClassVar[str] = (
        "a closed loop of torque over twist at every reversal, independent of speed: a loss factor that is "
        "constant over frequency, higher stiffness in small motion than in large; no impacts, and no decrease "
        "under load"
    )

    level: float = Field(0.0, ge=0.0, description="torque when all elements slip [Nm or N]")
    angle: float = Field(1e-3, gt=0.0, description="transition angle: level over stiffness at a reversal [rad or m]")
    spread: float = Field(1.0, ge=0.0, le=4.0, description="how far the slipping angles of the elements spread [1]")

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Return the sum of the torques of all elements."""
        limits = slipping_angles(values["angle"], values["spread"])
        stretched = _clip(gear.deflection - gear.own, limits)
        return gear.transmits(ca.SX(values["level"]) / len(NODES) * ca.sum1(stretched / limits))

    def after_step(self, gear: GearState, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Let the sliders follow; exact for a deflection that did not reverse within the step."""
        del step
        limits = slipping_angles(values["angle"], values["spread"])
        return gear.deflection - _clip(gear.deflection - gear.own, limits)

    def rest(self, gear: GearState, values: Mapping[str, Value]) -> ca.SX:
        """Return unstretched elements."""
        del values
        return ca.SX.ones(len(NODES)) * gear.deflection


def slipping_angles(angle: Value, spread: Value) -> ca.SX:
    """Return the slip angles of the elements.

    Args:
        angle: Transition angle [rad or m].
        spread: Exponent of the nodes [1].

    Returns:
        Angles [rad or m], SX (6, 1); the mean of their inverses is that of the transition angle.
    """
    powers = ca.exp(spread * ca.log(ca.SX(ca.DM(NODES))))
    return angle * powers * (ca.sum1(1 / powers) / len(NODES))


def _clip(value: ca.SX, limits: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(value, -limits), limits)
