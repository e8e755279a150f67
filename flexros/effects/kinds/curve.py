"""Curves: torques without a law, given at knots; what no law of the other effects explains."""

from __future__ import annotations

from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Literal, TypeVar

import casadi as ca

from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flexros.robot.symbolic.kinematics import Value

Extent = Literal[
    "largest speed",
    "lowest angle",
    "highest angle",
    "lowest deflection",
    "highest deflection",
    "first time",
    "last time",
]
"""What a log covers at a motor or spring [rad/s or m/s; rad or m; s since its begin]."""
SMALLEST = 1e-12
"""Smallest range of a curve [unit of its argument]."""


class AbstractCurve(AbstractLaw):
    """A torque that is piecewise linear between knots, constant beyond them, and linear in its sizes.

    A diagnosis adds one where the laws at a motor or spring leave much that a curve explains and no further law does.
    Beside the laws that it `extends`, the sizes that it shares with them are zero, so that theirs stay determined. A
    member is also an `AbstractMotorTorque` or an `AbstractGearLaw`, and provides `name`, `stage`, `size`, `words`,
    `extent`, its parameters, `ranges` of all sizes (`torques`) and `added`.
    """

    extent: ClassVar[Mapping[str, Extent]]
    """Parameters that are set to what a log covers."""
    intervals: ClassVar[int] = 0
    """Of a curve over time, the number of intervals between its knots. It is told from torques that depend on the
    motion only where the motion repeats in each of them."""

    told_by_reversals: ClassVar[bool] = False
    """Whether it is another curve over the same argument where the motor moves in one direction only."""

    @property
    def shown(self) -> tuple[str, ...]:
        """Sizes that a log shows which covers what the parameters in `extent` say; default: all."""
        return tuple(self.ranges)

    @property
    def neutral(self) -> bool:
        """Whether all sizes are zero."""
        return not any(getattr(self, name) for name in self.ranges)


_Curve = TypeVar("_Curve", bound=AbstractCurve)


def mirrored(curve: _Curve, factor: float) -> _Curve:
    """Return a curve from `low` to `high` as stated for a joint that counts the other way round.

    Args:
        curve: The curve.
        factor: Factor on its sizes, which come in the opposite order [1].
    """
    values, names = curve.parameter_values, tuple(curve.ranges)
    sizes = {name: factor * values[other] for name, other in zip(names, reversed(names))}
    return curve.model_copy(update={**sizes, "low": -values["high"], "high": -values["low"]})


def torques(names: Iterable[str], source: str = "chosen") -> Mapping[str, Range]:
    """Return the ranges of sizes that are torques of both signs, by name; at a spring multiples of its own torque."""
    return MappingProxyType(dict.fromkeys(names, Range("torque", 1e-3, 1.0, starts=1, signed=True, source=source)))


def share_of_range(argument: ca.SX, begin: Value, end: Value) -> ca.SX:
    """Return where an argument is between the ends of a range: 0 at its begin, 1 at its end.

    Args:
        argument: The argument, SX (1, 1).
        begin: Begin of the range.
        end: Its end; a range of no length counts as a very short one.
    """
    return (argument - begin) / ca.fmax(end - begin, SMALLEST)


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
