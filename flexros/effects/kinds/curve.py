"""Curves: torques at a motor without a law, given at knots; what no law of the other effects explains."""

from __future__ import annotations

from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Literal

import casadi as ca

from flexros.effects.kinds.motor_law import AbstractMotorTorque
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flexros.robot.symbolic.kinematics import Value

Extent = Literal["largest speed", "lowest angle", "highest angle"]
"""What the motion of a motor in a log covers [rad/s or m/s; rad or m]."""
SMALLEST = 1e-12
"""Smallest range of a curve [unit of its argument]."""


class AbstractCurve(AbstractMotorTorque):
    """A torque at a motor that is piecewise linear between knots, constant beyond them, and linear in its sizes.

    A diagnosis adds one where the laws at a motor leave much that a curve explains and no further law does. Beside the
    laws that it `extends`, the sizes that it shares with them are zero, so that theirs stay determined. A member
    provides `name`, `stage`, `size`, `words`, `extent`, its parameters, `ranges` of all sizes (`torques`) and `added`.
    """

    extent: ClassVar[Mapping[str, Extent]]
    """Parameters that are set to what the motion of a log covers."""

    @property
    def neutral(self) -> bool:
        """Whether all sizes are zero."""
        return not any(getattr(self, name) for name in self.ranges)


def torques(names: Iterable[str]) -> Mapping[str, Range]:
    """Return the ranges of sizes that are torques of both signs, by name."""
    return MappingProxyType(dict.fromkeys(names, Range("torque", 1e-3, 1.0, starts=1, signed=True)))


def piecewise_linear(argument: ca.SX, knots: Sequence[float], values: Sequence[Value]) -> ca.SX:
    """Interpolate linearly between knots; constant beyond them.

    Args:
        argument: Where the curve is evaluated, SX (1, 1).
        knots: Arguments of the knots, ascending, shape (k,).
        values: Values there, shape (k,).
    """
    result = ca.SX(values[0])
    for (begin, before), (end, after) in pairwise(zip(knots, values, strict=True)):
        result += (after - before) * ca.fmin(ca.fmax((argument - begin) / (end - begin), 0), 1)
    return result
