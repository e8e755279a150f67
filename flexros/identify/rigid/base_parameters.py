"""Base parameters: the combinations of parameters that the torque of a rigid robot can tell at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.rigid.regressor import RigidRegressor
    from flexros.identify.rigid.standard_parameters import StandardParameter

_DEPENDENT = 1e-8
"""Share of a column that others leave unexplained below which it depends on them (chosen: far above round-off)."""

_ROUND_OFF = 1e-12
"""Size of a column, relative to the largest, below which it is round-off of zero (chosen)."""


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """Base parameters pi_b = combination @ pi of a robot, r of P (Moberg 2007, after eq. 4.11).

    Attributes:
        standard: The P parameters that they are made of.
        leading: Place in `standard` of the parameter that each base parameter is named after, length r.
        combination: Matrix from parameters to base parameters, shape (r, P); 1 at the leading one.
    """

    standard: tuple[StandardParameter, ...]
    leading: tuple[int, ...]
    combination: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the leading parameters, length r."""
        return tuple(self.standard[place].name for place in self.leading)

    @property
    def units(self) -> tuple[str, ...]:
        """SI units, length r."""
        return tuple(self.standard[place].unit for place in self.leading)

    @property
    def nominal(self) -> FloatArray:
        """Values by the robot file, shape (r,)."""
        nominal: FloatArray = self.combination @ np.array([parameter.nominal for parameter in self.standard])
        return nominal

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Names of the parameters that no motion can show."""
        used = np.any(self.combination != 0, axis=0)
        return tuple(p.name for p, shown in zip(self.standard, used, strict=True) if not shown)

    def parts(self, number: int) -> dict[str, float]:
        """Factors of the parameters that a base parameter is made of, by name, the leading one first."""
        row, lead = self.combination[number], self.leading[number]
        others = [place for place in range(len(row)) if row[place] != 0 and place != lead]
        return {self.standard[place].name: float(f"{row[place]:.10g}") for place in (lead, *others)}

    def words(self, number: int) -> str:
        """Say which combination a base parameter is, e.g. "mass of body_1 + inertia of motor_1 at the arm"."""
        named = {parameter.name: parameter.words for parameter in self.standard}
        text = ""
        for name, factor in self.parts(number).items():
            size = "" if abs(abs(factor) - 1) < _DEPENDENT else f"{abs(factor):.6g} "
            sign = " - " if factor < 0 else " + " if text else ""
            text += f"{sign}{size}{named[name]}"
        return text


def base_parameters(regressor: RigidRegressor, n_motors: int, seed: int = 0) -> BaseParameters:
    """Find the base parameters of a robot from its regressor at random motions (M. Gautier, 1991).

    Orthogonalisation of the columns in the order of the parameters reveals the rank: a column that the columns before
    leave no share of belongs to a parameter that adds to those before it.

    Args:
        regressor: The regressor.
        n_motors: Number of motors M.
        seed: Of the random motions.

    Returns:
        The base parameters.
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
    others = [place for place in shown if place not in leading]
    size = np.linalg.norm(H, axis=0)
    weights = np.linalg.lstsq(H[:, leading] / size[leading], H[:, others], rcond=None)[0] / size[leading][:, None]
    share = np.abs(weights) * size[leading][:, None] / size[others]
    combination[:, others] = np.where(share > _DEPENDENT, weights, 0.0)
    return BaseParameters(regressor.parameters, tuple(leading), combination)


def independent_columns(matrix: FloatArray, least_share: float) -> list[int]:
    """Choose columns one after the other that the chosen ones before do not explain.

    Args:
        matrix: Shape (n, k).
        least_share: Share of a column's norm that must be left unexplained.

    Returns:
        Places of the chosen columns; columns of zeros are never among them.
    """
    size = np.linalg.norm(matrix, axis=0)
    basis = np.empty((matrix.shape[0], 0))
    chosen = []
    for place in _present(matrix):
        rest = matrix[:, place] / size[place]
        for _ in range(2):  # once more removes what round-off left
            rest = rest - basis @ (basis.T @ rest)
        left = np.linalg.norm(rest)
        if left > least_share:
            chosen.append(place)
            basis = np.column_stack([basis, rest / left])
    return chosen


def _present(matrix: FloatArray) -> list[int]:
    """Places of the columns that are not zero."""
    size = np.linalg.norm(matrix, axis=0)
    return [int(place) for place in np.flatnonzero(size > _ROUND_OFF * size.max(initial=0.0))]
