"""Linear systems by their matrices, continuous or discrete."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from typing import Self

    from flexros.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class AbstractLinearSystem:
    """A linear system with states x, inputs u and outputs y = C x + D u; the states go on by A x + B u.

    Attributes:
        A: Shape (n, n).
        B: Shape (n, n_inputs).
        C: Shape (n_outputs, n).
        D: Shape (n_outputs, n_inputs).
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

    def then(self, after: Self) -> Self:
        """Return this system in series with one that takes its output."""
        A = np.block([[self.A, np.zeros((self.order, after.order))], [after.B @ self.C, after.A]])
        B = np.vstack([self.B, after.B @ self.D])
        return type(self)(A, B, np.hstack([after.D @ self.C, after.C]), after.D @ self.D)

    def transfer(self, variable: ComplexArray) -> ComplexArray:
        """Return C (z - A)^-1 B + D.

        Args:
            variable: Values z of the variable of the transform, shape (F,).

        Returns:
            Shape (F, n_outputs, n_inputs).
        """
        z = variable[:, None, None]
        memory = np.linalg.solve(z * np.eye(self.order) - self.A, np.broadcast_to(self.B, (len(z), *self.B.shape)))
        return np.asarray(self.C @ memory + self.D)
