"""Spring laws: linear, piecewise linear and cubic."""

from __future__ import annotations

from typing import Any

import casadi as ca
from pydantic import Field, model_validator

from flexros.config.settings import Settings
from flexros.robot.quantity import AnyUnit


class PiecewiseLinear(Settings):
    """Odd piecewise linear law with slope `slopes[i]` between `knots[i-1]` and `knots[i]`, the last one beyond."""

    knots: tuple[float, ...] = Field(min_length=1, description="deflections at which the slope changes, ascending, > 0")
    slopes: tuple[float, ...] = Field(description="stiffness of each segment, one more than knots")
    source: str = ""
    tolerance: float | None = Field(None, ge=0)

    @model_validator(mode="after")
    def _check(self) -> PiecewiseLinear:
        if len(self.slopes) != len(self.knots) + 1:
            raise ValueError(
                f"has {len(self.knots)} knots and {len(self.slopes)} slopes, but needs one slope more than knots"
            )
        if any(b <= a for a, b in zip((0.0, *self.knots), self.knots)):
            raise ValueError(f"knots are {list(self.knots)}, but must ascend and be positive (the law is odd)")
        if min(self.slopes) < 0 or max(self.slopes) == 0:
            raise ValueError(f"slopes are {list(self.slopes)}, but must not be negative, and not all zero")
        return self


class Cubic(Settings):
    """Cubic law: torque = linear * deflection + cubic * deflection^3."""

    linear: float = Field(ge=0, description="stiffness at zero deflection")
    cubic: float = Field(ge=0, description="coefficient of the third power")
    source: str = ""
    tolerance: float | None = Field(None, ge=0)


class Spring(Settings):
    """One spring: exactly one of the three laws. In YAML a plain number is a linear stiffness."""

    stiffness: AnyUnit | None = Field(None, description="linear stiffness [Nm/rad or N/m]")
    piecewise_linear: PiecewiseLinear | None = None
    cubic: Cubic | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_plain(cls, data: Any) -> Any:
        if isinstance(data, (int, float)) or (isinstance(data, dict) and "value" in data):
            return {"stiffness": data}
        return data

    @model_validator(mode="after")
    def _one_law(self) -> Spring:
        laws = [self.stiffness, self.piecewise_linear, self.cubic]
        if sum(law is not None for law in laws) != 1:
            raise ValueError("needs exactly one law: a number, or one of the keys stiffness, piecewise_linear, cubic")
        if self.stiffness is not None and self.stiffness.value < 0:
            raise ValueError(f"is {self.stiffness.value:g}, but a stiffness must not be negative")
        return self

    @property
    def at_zero(self) -> float:
        """Stiffness at zero deflection [Nm/rad or N/m]."""
        if self.stiffness is not None:
            return self.stiffness.value
        if self.piecewise_linear is not None:
            return self.piecewise_linear.slopes[0]
        assert self.cubic is not None
        return self.cubic.linear

    @property
    def linear(self) -> bool:
        """Whether the law is linear."""
        return self.stiffness is not None

    def force(self, deflection: ca.SX, scale: ca.SX | float) -> ca.SX:
        """Return the transmitted torque or force [Nm or N], with the sign of the deflection.

        Args:
            deflection: Deflection [rad or m].
            scale: Stiffness of a linear spring [Nm/rad or N/m]; factor on the whole law of a nonlinear one.
        """
        if self.piecewise_linear is not None:
            law = self.piecewise_linear
            value = law.slopes[0] * deflection
            for knot, below, above in zip(law.knots, law.slopes, law.slopes[1:]):
                beyond = ca.fmax(deflection - knot, 0) + ca.fmin(deflection + knot, 0)
                value = value + (above - below) * beyond
            return scale * value
        if self.cubic is not None:
            return scale * (self.cubic.linear + self.cubic.cubic * deflection**2) * deflection
        return scale * deflection

    def deflection(self, force: ca.SX, scale: ca.SX | float) -> ca.SX:
        """Return the deflection [rad or m] at a transmitted torque or force, the inverse of `force`.

        Args:
            force: Transmitted torque or force [Nm or N].
            scale: As for `force`.

        Raises:
            ValueError: The law has a segment without stiffness, where the deflection is not unique.
        """
        if self.at_zero <= 0 or (self.piecewise_linear is not None and min(self.piecewise_linear.slopes) <= 0):
            raise ValueError("a spring law with a segment of zero stiffness has no inverse")
        value = force / scale
        if self.piecewise_linear is not None:
            law, reached, below_knot = self.piecewise_linear, 0.0, 0.0
            found = value / law.slopes[0]
            for knot, below, above in zip(law.knots, law.slopes, law.slopes[1:]):
                reached, below_knot = reached + below * (knot - below_knot), knot
                beyond = ca.fmax(value - reached, 0) + ca.fmin(value + reached, 0)
                found = found + (1 / above - 1 / below) * beyond
            return found
        if self.cubic is not None and self.cubic.cubic > 0:  # the one real root of the cubic equation
            p, q = self.cubic.linear / self.cubic.cubic, value / self.cubic.cubic
            return ca.SX(2 * (p / 3) ** 0.5 * ca.sinh(ca.asinh(1.5 * q / p * (3 / p) ** 0.5) / 3))
        return value if self.cubic is None else value / self.cubic.linear  # a linear spring has its stiffness as scale

    def energy(self, deflection: ca.SX, scale: ca.SX | float) -> ca.SX:
        """Return the potential energy [J], the integral of `force` from zero deflection; arguments as for `force`."""
        if self.piecewise_linear is not None:
            law = self.piecewise_linear
            value = law.slopes[0] * deflection**2 / 2
            for knot, below, above in zip(law.knots, law.slopes, law.slopes[1:]):
                beyond = ca.fmax(deflection - knot, 0) ** 2 + ca.fmin(deflection + knot, 0) ** 2
                value = value + (above - below) * beyond / 2
            return scale * value
        if self.cubic is not None:
            return scale * (self.cubic.linear * deflection**2 / 2 + self.cubic.cubic * deflection**4 / 4)
        return scale * deflection**2 / 2
