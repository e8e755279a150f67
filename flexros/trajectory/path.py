"""Contract of a path: a point as a function of a path parameter."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

MAX_DERIVATIVES = 4
"""Highest derivative of paths, time laws and trajectories (the flexible-joint feedforward needs four)."""


class AbstractPath(ABC):
    """A geometric path P(s), s from 0 to `extent`, at least four times continuously differentiable.

    The coordinates are tool coordinates (positions [m], for six coordinates followed by a rotation vector [rad]) or
    joint positions [rad or m]. A new path must provide:

    1. `extent`: largest value of the path parameter, in `parameter_unit`, 0 only for a single point; the smallest is 0;
    2. `parameter_unit`: unit of the parameter, for messages;
    3. `n_out`: number of coordinates;
    4. `pace`: largest length travelled per unit of the parameter, by which limits along the path are converted;
    5. `coordinate_pace`: the same for every coordinate by itself, by which limits of joints are converted;
    6. `derivatives`: P and its derivatives with respect to the parameter.
    """

    parameter_unit: str

    @property
    @abstractmethod
    def extent(self) -> float:
        """Largest value of the path parameter, in `parameter_unit`."""

    @property
    @abstractmethod
    def n_out(self) -> int:
        """Number of coordinates."""

    @property
    @abstractmethod
    def pace(self) -> float:
        """Largest length per unit of the parameter: max |dP/ds| over the path."""

    @property
    @abstractmethod
    def coordinate_pace(self) -> FloatArray:
        """Largest |dP_i/ds| of every coordinate over the path, shape (n_out,)."""

    @abstractmethod
    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """Return the point and its derivatives with respect to the path parameter.

        Args:
            s: Path parameter in [0, extent], shape (n,).
            order: Highest derivative, 0 to 4.

        Returns:
            P, dP/ds, ..., shape (order + 1, n, n_out).
        """

    @property
    def start(self) -> FloatArray:
        """First point, shape (n_out,)."""
        return self.point_at(0.0)

    @property
    def end(self) -> FloatArray:
        """Last point, shape (n_out,)."""
        return self.point_at(self.extent)

    def point_at(self, s: float) -> FloatArray:
        """Return the point at a path parameter, at the nearer end if it is beyond, shape (n_out,)."""
        result: FloatArray = self.derivatives(np.array([min(max(s, 0.0), self.extent)]), 0)[0, 0]
        return result


def point(values: object, name: str, size: int | None = None) -> FloatArray:
    """Check the coordinates of a point.

    Args:
        values: Sequence of numbers.
        name: What the point is, for the message, e.g. "end of the line".
        size: Number of coordinates it must have; any if None.

    Returns:
        The coordinates, read-only, shape (n,).

    Raises:
        InputError: Not a vector of finite numbers of that size.
    """
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"the {name} is {values}, allowed is a list of numbers; correct the point") from error
    if array.ndim != 1 or array.size == 0:
        raise InputError(f"the {name} has shape {array.shape}, allowed is one list of numbers; correct the point")
    if not np.all(np.isfinite(array)):
        raise InputError(f"the {name} is {text(array)}, allowed are finite numbers; correct the point")
    if size is not None and array.size != size:
        raise InputError(f"the {name} has {array.size} coordinates, allowed are {size} as for the start")
    array.flags.writeable = False
    return array


def text(coordinates: FloatArray) -> str:
    """Format coordinates for a message, e.g. "(2.1464, -0.3546)"."""
    return "(" + ", ".join(f"{value:.6g}" for value in coordinates) + ")"
