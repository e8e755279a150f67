"""Path of a single point, for a robot at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath, point

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False, init=False)
class Rest(AbstractPath):
    """One point, from which no path parameter leads away.

    Args:
        where: Tool coordinates or joint positions, shape (n_out,).

    Raises:
        InputError: Not a vector of finite numbers.
    """

    where: FloatArray
    parameter_unit = "1"

    def __init__(self, where: FloatArray) -> None:
        object.__setattr__(self, "where", point(where, "point of rest"))

    @property
    def extent(self) -> float:
        """0."""
        return 0.0

    @property
    def n_out(self) -> int:
        """Number of coordinates."""
        return self.where.size

    @property
    def pace(self) -> float:
        """0: nothing moves."""
        return 0.0

    @property
    def coordinate_pace(self) -> FloatArray:
        """Zeros, shape (n_out,)."""
        return np.zeros(self.n_out)

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`; the same point for every parameter."""
        result = np.zeros((order + 1, np.size(s), self.n_out))
        result[0] = self.where
        return result
