"""Scaling of fitted parameters: logarithms of positive ones, multiples of a typical size of the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.robot.robot import Robot

POSITIVE = ("stiffness", "damping", "mass", "viscous_friction", "xx", "yy", "zz")
"""Last words of the names of parameters that cannot be negative; in addition to the inertia of a motor."""

TYPICAL = {"x": 0.1, "y": 0.1, "z": 0.1, "viscous_friction": 10.0, "damping": 10.0, "stiffness": 1e4, "mass": 1.0}
"""Typical sizes [SI] of parameters that are not logarithmic, by the last word of the name (chosen); 1 for others."""

DECADES = 1.0
"""Default bounds of a logarithmic parameter: this many decades above and below the nominal value."""


@dataclass(frozen=True, eq=False)
class ParameterScale:
    """Map between values theta and the scaled parameters x of a fit.

    Attributes:
        names: Names of the parameters, length P.
        nominal: Nominal values [SI], shape (P,).
        logarithmic: Whether x = log(theta), else x = theta / size, shape (P,).
        size: Typical size [SI], shape (P,); 1 for logarithmic ones.
        lowest: Lowest possible value [SI]: 0, or -inf for parameters of either sign, shape (P,).
    """

    names: tuple[str, ...]
    nominal: FloatArray
    logarithmic: BoolArray
    size: FloatArray
    lowest: FloatArray

    def scaled(self, values: FloatArray) -> FloatArray:
        """Return x of values, shape (..., P)."""
        safe = np.where(self.logarithmic, values, 1.0)
        scaled: FloatArray = np.where(self.logarithmic, np.log(safe), values / self.size)
        return scaled

    def values(self, x: FloatArray) -> FloatArray:
        """Return the values of x, shape (..., P)."""
        values: FloatArray = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, x, 0.0)), x * self.size)
        return values

    def per_value(self, values: FloatArray) -> FloatArray:
        """Return d theta / dx, shape (P,)."""
        return np.where(self.logarithmic, values, self.size)

    def bounds(self, given: Mapping[str, tuple[float, float]] | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of x.

        Args:
            given: Lower and upper bound of values [SI] by name; default: a factor of 10 above and below the nominal
                value for logarithmic parameters, the lowest possible value for the others.

        Returns:
            Lower and upper bounds, each of shape (P,).

        Raises:
            InputError: A name is not an unknown parameter, or its lower bound is not below its upper bound.
        """
        reach = np.log(10.0) * DECADES
        centre = self.scaled(self.nominal)
        lower = np.where(self.logarithmic, centre - reach, self.lowest / self.size)
        upper = np.where(self.logarithmic, centre + reach, np.inf)
        for name, (low, high) in (given or {}).items():
            if name not in self.names:
                raise unknown_name("fitted parameter", name, self.names, "bounds")
            index = self.names.index(name)
            if not low < high or (self.logarithmic[index] and low <= 0):
                raise InputError(
                    f"bounds: {name} has the bounds {low:g} and {high:g}, allowed is a lower bound "
                    f"{'above 0 and ' if self.logarithmic[index] else ''}below the upper one; correct them"
                )
            pair = np.array([low, high])
            lower[index], upper[index] = np.log(pair) if self.logarithmic[index] else pair / self.size[index]
        return lower, upper


def parameter_scale(robot: Robot, names: Sequence[str]) -> ParameterScale:
    """Choose the scaling of each unknown parameter.

    Args:
        robot: The robot with its nominal values.
        names: Names of the unknown parameters, length P.

    Returns:
        Logarithms for values above zero that cannot be negative, multiples of a typical size for the others.

    Raises:
        InputError: No name, a duplicate name, or one that is not a parameter of the robot.
    """
    if not names:
        raise InputError(
            f"no unknown parameter is named for robot {robot.name}: give names, or list them in the robot file under "
            "unknown_parameters"
        )
    for name in names:
        if name not in robot.parameters:
            raise unknown_name(f"parameter of robot {robot.name}", name, robot.parameters, "unknown parameters")
        if list(names).count(name) > 1:
            raise InputError(f"unknown parameters name {name} more than once; name it only once")
    nominal = np.array([robot.parameters[name].value for name in names])
    positive = np.array([_cannot_be_negative(name) for name in names])
    logarithmic = positive & (nominal > 0)
    typical = np.array([TYPICAL.get(name.rsplit(".", 1)[-1], 1.0) for name in names])
    size = np.where(logarithmic, 1.0, np.maximum(np.abs(nominal), typical))
    return ParameterScale(tuple(names), nominal, logarithmic, size, np.where(positive, 0.0, -np.inf))


def _cannot_be_negative(name: str) -> bool:
    last = name.rsplit(".", 1)[-1]
    return last in POSITIVE or (name.startswith("motor_") and last == "inertia")
