"""Base parameters: the combinations of parameters that are identifiable from the torque of a rigid robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.rigid.regressor import RigidRegressor
    from flexros.identify.rigid.standard_parameters import StandardParameter

_DEPENDENT = 1e-8
"""Share of a column that the others do not explain below which it is dependent (chosen: far above round-off)."""

_ROUND_OFF = 1e-12
"""Norm of a column, relative to the largest, below which it is zero except for round-off."""


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """Base parameters pi_b = combination @ pi of a robot, r of P (Moberg 2007, after eq. 4.11).

    Attributes:
        standard: The P standard parameters.
        leading: Index in `standard` of the parameter after which each base parameter is named, length r.
        combination: Matrix from parameters to base parameters, shape (r, P); 1 at the leading one.
    """

    standard: tuple[StandardParameter, ...]
    leading: tuple[int, ...]
    combination: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the leading parameters, length r."""
        return tuple(self.standard[index].name for index in self.leading)

    @property
    def units(self) -> tuple[str, ...]:
        """SI units, length r."""
        return tuple(self.standard[index].unit for index in self.leading)

    @property
    def nominal(self) -> FloatArray:
        """Nominal values, shape (r,)."""
        nominal: FloatArray = self.combination @ np.array([parameter.nominal for parameter in self.standard])
        return nominal

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Names of the parameters that no motion excites."""
        used = np.any(self.combination != 0, axis=0)
        return tuple(p.name for p, shown in zip(self.standard, used, strict=True) if not shown)

    def parts(self, index: int) -> dict[str, float]:
        """Factors of the parameters in a base parameter, by name, the leading one first."""
        row, lead = self.combination[index], self.leading[index]
        others = [column for column in range(len(row)) if row[column] != 0 and column != lead]
        return {self.standard[column].name: float(f"{row[column]:.10g}") for column in (lead, *others)}

    def words(self, index: int) -> str:
        """Describe a base parameter, e.g. "mass of body_1 + inertia of motor_1 at the arm"."""
        named = {parameter.name: parameter.words for parameter in self.standard}
        text = ""
        for name, factor in self.parts(index).items():
            size = "" if abs(abs(factor) - 1) < _DEPENDENT else f"{abs(factor):.6g} "
            sign = " - " if factor < 0 else " + " if text else ""
            text += f"{sign}{size}{named[name]}"
        return text


def base_parameters(regressor: RigidRegressor, n_motors: int, seed: int = 0) -> BaseParameters:
    """Determine the base parameters of a robot from its regressor at random motions (M. Gautier, 1991).

    Orthogonalisation of the columns in the order of the parameters reveals the rank: a column that is a combination of
    the previous ones belongs to a parameter that is added to theirs.

    Args:
        regressor: The regressor.
        n_motors: Number of motors M.
        seed: Seed of the random motions.
    """
    rng = np.random.default_rng(seed)
    n = 3 * len(regressor.parameters)
    q, v, a = (scale * rng.uniform(-1, 1, (n, n_motors)) for scale in (np.pi, 3.0, 10.0))
    H = regressor.matrix(q, v, a)
    H = H.reshape(n * n_motors, -1)
    leading = independent_columns(H, _DEPENDENT)
    combination = np.zeros((len(leading), H.shape[1]))
    combination[range(len(leading)), leading] = 1.0
    shown = _present(H)
    others = [column for column in shown if column not in leading]
    size = np.linalg.norm(H, axis=0)
    weights = np.linalg.lstsq(H[:, leading] / size[leading], H[:, others], rcond=None)[0] / size[leading][:, None]
    share = np.abs(weights) * size[leading][:, None] / size[others]
    combination[:, others] = np.where(share > _DEPENDENT, weights, 0.0)
    return BaseParameters(regressor.parameters, tuple(leading), combination)


def independent_columns(matrix: FloatArray, least_share: float) -> list[int]:
    """Choose columns one after the other that the previous chosen ones do not explain.

    Args:
        matrix: Shape (n, k).
        least_share: Share of a column's norm that must remain unexplained.

    Returns:
        Indices of the chosen columns; columns of zeros are never among them.
    """
    size = np.linalg.norm(matrix, axis=0)
    basis = np.empty((matrix.shape[0], 0))
    chosen = []
    for column in _present(matrix):
        rest = matrix[:, column] / size[column]
        for _ in range(2):  # the second pass removes round-off of the first
            rest = rest - basis @ (basis.T @ rest)
        left = np.linalg.norm(rest)
        if left > least_share:
            chosen.append(column)
            basis = np.column_stack([basis, rest / left])
    return chosen


def _present(matrix: FloatArray) -> list[int]:
    """Indices of the columns that are not zero."""
    size = np.linalg.norm(matrix, axis=0)
    return [int(column) for column in np.flatnonzero(size > _ROUND_OFF * size.max(initial=0.0))]
