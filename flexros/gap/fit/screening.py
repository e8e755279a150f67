"""Score-test estimates: what candidates would gain in addition to a fit, and what its effects are worth.

All by linear theory on a part of the weighted prediction errors, which costs no prediction beyond those of each
candidate alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import comb
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.gap.fit.damped_steps import may_move
from flexros.gap.fit.least_norm import least_norm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.linearisation import Linearised

IMITATED = 1e-6
"""Share of a direction, in single precision, that rounding leaves where the fitted parameters imitate it [1]."""
MOST_PARTS = 2000
"""Parts of one size of a known set that are compared; of more there are none but by growth [1] (chosen)."""
BEAM = 30
"""Sets of directions of each size that grow further (chosen)."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A fit, linearised on some of its prediction errors.

    Attributes:
        residual: Weighted prediction errors r, shape (n_rows,).
        slopes: Their derivatives J to the fitted parameters, shape (n_rows, n_fitted).
        prior: Information of the prior on each parameter [1], shape (n_fitted,).
        pulled: Part of the prior in the gradient, shape (n_fitted,).
        weight: Prediction errors that each row stands for [1].
        known: Information of the parameters with the prior, where it is known already, as that takes a product of all
            rows, shape (n_fitted, n_fitted).
    """

    residual: FloatArray
    slopes: FloatArray
    prior: FloatArray
    pulled: FloatArray
    weight: float
    known: FloatArray | None = None

    def gains(self, changes: NDArray[Any]) -> tuple[FloatArray, FloatArray]:
        """Estimate by how much directions lower the sum of squares when all parameters are fitted again.

        Tolerated deviations have a prior penalty, so that a direction which they imitate still gains what they cost.

        Args:
            changes: Changes of the prediction errors, shape (n_rows, k).

        Returns:
            With the best length of each direction, and with the length that it has, shape (k,) each.
        """
        shared = self._shared(changes)
        raw = self.weight * np.einsum("ij,ij->j", changes, changes, dtype=float)
        slope = self._slope(changes, shared)
        curvature = np.asarray(raw - np.einsum("ij,ij->j", shared, self._refitted(shared)), dtype=float)
        scaled = np.where(slope > 0, slope**2 / np.maximum(curvature, IMITATED * raw + 1e-300), 0.0)
        return scaled, 2 * slope - curvature

    def independent(self, changes: NDArray[Any], most: int, kept: float) -> list[int]:
        """Select directions that each gain nearly as much together as alone.

        With the slope b and the curvature G of the sum of squares along the directions, all fitted parameters free, the
        gain of direction j after the directions S is (b_j - G_jS G_SS^-1 b_S)^2 / (G_jj - G_jS G_SS^-1 G_Sj).

        Args:
            changes: Changes of the prediction errors, those of the largest gains first, shape (n_rows, k).
            most: Most directions.
            kept: Least share of its own gain, and of its own curvature, that a direction keeps [1].

        Returns:
            Indices of the selected directions, in their order.
        """
        changes = changes.astype(float)
        slope, curvature = self._slopes_and_curvatures(changes)
        own = np.maximum(np.diag(curvature), 1e-300)
        selected: list[int] = []
        for index in np.flatnonzero(slope > 0):
            if len(selected) == most:
                break
            among = curvature[selected, index]
            weights = least_norm(curvature[np.ix_(selected, selected)], among, 1e-12)
            left, along = own[index] - among @ weights, slope[index] - slope[selected] @ weights
            if left > kept * own[index] and along > 0 and along**2 / left > kept * slope[index] ** 2 / own[index]:
                selected.append(int(index))
        return selected

    def best_sets(self, changes: NDArray[Any], most: int, known: Sequence[int] = ()) -> list[tuple[int, ...]]:
        """Find the sets of directions that lower the sum of squares most together, one of every size.

        All pairs are compared; larger sets are the best ones of the size before with one direction more, or parts of a
        known one.

        Args:
            changes: Changes of the prediction errors, shape (n_rows, k).
            most: Largest size [1].
            known: Directions of a set that is good already.

        Returns:
            Indices of the directions of each set, the smallest set first.
        """
        changes = changes.astype(float)
        slope, curvature = self._slopes_and_curvatures(changes)
        raw = self.weight * np.einsum("ij,ij->j", changes, changes)
        seen = np.diag(curvature) > IMITATED * raw
        scale = np.sqrt(np.where(seen, np.diag(curvature), 1.0))
        alike, slope = curvature / np.outer(scale, scale), slope / scale

        def gain(members: tuple[int, ...]) -> float:
            rows = np.ix_(members, members)
            return float(slope[list(members)] @ least_norm(alike[rows], slope[list(members)], 1e-6))

        every = [int(one) for one in np.flatnonzero(seen)]
        found: list[tuple[int, ...]] = []
        before: list[tuple[int, ...]] = [()]
        for size in range(1, min(most, len(every)) + 1):
            sets = {tuple(sorted((*one, other))) for one in before for other in every if other not in one}
            own = sorted(set(known) & set(every))
            sets |= set(combinations(own, size)) if comb(len(own), size) < MOST_PARTS else set()
            ranked = sorted(sets, key=lambda one: -gain(one))
            before = ranked if size == 1 else ranked[:BEAM]
            found.append(ranked[0])
        return found

    def without(self, columns: BoolArray, change: FloatArray) -> Surroundings:
        """Return the same fit with some parameters at values that switch their effect off.

        Args:
            columns: Whether a parameter is one of them, shape (n_fitted,).
            change: Change of the prediction errors when they are switched off, shape (n_rows,).
        """
        kept = ~columns
        return Surroundings(
            self.residual + change,
            self.slopes[:, kept],
            self.prior[kept],
            self.pulled[kept],
            self.weight,
            self._information[np.ix_(kept, kept)],
        )

    def left(self, changes: NDArray[Any]) -> float:
        """Estimate the sum of squares when directions and all parameters are fitted together [1].

        Args:
            changes: Changes of the prediction errors, shape (n_rows, k).
        """
        return self._beside(changes).least

    def sizes(self, changes: NDArray[Any]) -> FloatArray:
        """Estimate the lengths of directions when they and all parameters are fitted together [1], shape (k,).

        Args:
            changes: Changes of the prediction errors, shape (n_rows, k).
        """
        beside = self._beside(changes)
        return -beside._refitted(beside._gradient)[len(self.prior) :]

    def alike(self, column: int, change: NDArray[Any]) -> float:
        """Return the squared correlation of a fitted parameter and of a direction, all parameters free [1].

        Args:
            column: Number of the parameter.
            change: Change of the prediction errors along the direction, shape (n_rows,).
        """
        beside = self._beside(change[:, None])
        covariance = np.linalg.pinv(beside._information, rcond=1e-12, hermitian=True)
        spread = covariance[column, column] * covariance[-1, -1]
        return float(covariance[column, -1] ** 2 / max(spread, 1e-300))

    @property
    def least(self) -> float:
        """Sum of squares when all parameters are fitted again, by linear theory [1]; infinite for what runs away."""
        with np.errstate(over="ignore"):
            squares = self.weight * float(self.residual @ self.residual)
        return squares - self.fall if np.isfinite(squares) else np.inf

    @cached_property
    def fall(self) -> float:
        """Fall of the sum of squares when all parameters are fitted again, by linear theory [1]."""
        gradient = self._gradient
        return float(gradient @ self._refitted(gradient))

    @cached_property
    def _gradient(self) -> FloatArray:
        return np.asarray(self.weight * self.slopes.T @ self.residual + self.pulled, dtype=float)

    def _beside(self, changes: NDArray[Any]) -> Surroundings:
        """Return the same fit with directions as further parameters, which have no prior."""
        slopes, nothing = np.hstack([self.slopes, changes.astype(float)]), np.zeros(changes.shape[1])
        prior, pulled = np.append(self.prior, nothing), np.append(self.pulled, nothing)
        return Surroundings(self.residual, slopes, prior, pulled, self.weight)

    def _shared(self, changes: NDArray[Any]) -> FloatArray:
        """Return the curvature of the sum of squares along a parameter and a direction, shape (n_fitted, k)."""
        return np.asarray(self.weight * self.slopes.T @ changes, dtype=float)

    def _slope(self, changes: NDArray[Any], shared: FloatArray) -> FloatArray:
        """Return the fall of the sum of squares along directions, all parameters free, shape (k,)."""
        slope: FloatArray = -(self.weight * self.residual @ changes - self._refitted(self._gradient) @ shared)
        return slope

    def _slopes_and_curvatures(self, changes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return slopes and curvatures along directions, all parameters free, shapes (k,) and (k, k)."""
        shared = self._shared(changes)
        curvature = self.weight * changes.T @ changes - shared.T @ self._refitted(shared)
        return self._slope(changes, shared), np.asarray(curvature, dtype=float)

    @cached_property
    def _information(self) -> FloatArray:
        if self.known is not None:
            return self.known
        return np.asarray(self.weight * self.slopes.T @ self.slopes + np.diag(self.prior), dtype=float)

    def _refitted(self, gradient: FloatArray) -> FloatArray:
        return least_norm(self._information, gradient, 1e-12)


def surroundings_of(fit: CandidateFit, line: Linearised, rows: IntArray, misfit: float = 1.0) -> Surroundings:
    """Reduce a linearised fit to some of its prediction errors.

    Parameters at a bound that would leave it are held there. Moved by linear theory, a number of the model that is far
    off pretends that its tolerance, moved still farther, gains all that a candidate gains.

    Args:
        fit: The fit.
        line: The same, linearised.
        rows: The prediction errors, shape (n_rows,).
        misfit: Weight of the prior of tolerated deviations, see `FitData` [1].
    """
    prior = np.zeros(len(fit.theta))
    prior[fit.predictor.n_effect :] = misfit
    moves = may_move(fit.predictor, fit.theta, line)
    return Surroundings(
        line.residual[rows],
        line.slopes[rows] * moves,
        prior,
        prior * fit.theta * moves,
        len(line.residual) / max(len(rows), 1),
    )
