"""D-optimal number of experiments in each of many candidate positions, by convex relaxation and its dual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

GAP = 1e-6
"""Duality gap at which a design counts as optimal, in log det (chosen); a design of efficiency exp(-GAP / P)."""
_SUPPORT = 1e-7
"""Smaller weights than this count as none (chosen)."""
_WARM_STEPS = 60
"""Steps of the multiplicative algorithm that find the first positions (chosen)."""
_ADDED = 40
"""Most positions that a round adds (chosen)."""
_ROUNDS = 60
"""Most rounds (chosen); a handful suffices."""
_NEWTON_STEPS = 50
"""Most Newton steps of a round (chosen); a handful suffices unless shares vanish one by one."""


@dataclass(frozen=True, eq=False)
class Design:
    """Optimal shares of experiments over candidate positions, with the proof of their optimality.

    Attributes:
        weights: Share of the experiments in each candidate, shape (Q,), sum 1.
        dual: Matrix W of the dual problem, the inverse of the information of the design, shape (P, P).
        gap: Duality gap in log det: an upper bound of what any other shares could gain.
        support: Candidates with a share above zero, largest first, shape (S,).
        sensitivities: tr(W I_i) of each candidate, shape (Q,). Without `prior` none exceeds P at the optimum, and
            those of the support equal P (Kiefer and Wolfowitz 1960).
        information: Information of one experiment in each candidate, shape (Q, P, P).
        prior: Information before any experiment, shape (P, P).
    """

    weights: FloatArray
    dual: FloatArray
    gap: float
    support: IntArray
    sensitivities: FloatArray
    information: FloatArray
    prior: FloatArray

    @property
    def log_det(self) -> float:
        """Logarithm of the determinant of the information per experiment."""
        return float(-np.linalg.slogdet(self.dual)[1])


def d_optimal(information: FloatArray, prior: FloatArray | None = None, gap: float = GAP) -> Design:
    """Find the shares x of experiments that maximise log det(P0 + sum_i x_i I_i) with x >= 0, sum x = 1.

    The dual problem is solved instead (Wernholt and Löfberg 2007): minimise -log det W + tr(W P0) + nu - P subject to
    tr(W I_i) <= nu for all i. It has few variables and many constraints, of which only those near the optimum matter:
    they are generated. The shares are the multipliers of the constraints. The gap is that of the shares themselves,
    max_i tr(W I_i) - sum_i x_i tr(W I_i) with W the inverse of their information, and does not rely on the solver.

    Args:
        information: Information of one experiment in each candidate, symmetric and not negative, shape (Q, P, P).
        prior: P0, shape (P, P); default: none.
        gap: Duality gap at which to stop.

    Returns:
        The design.

    Raises:
        InputError: All candidates together do not determine the parameters and there is no prior.
    """
    start = np.zeros(information.shape[1:]) if prior is None else np.asarray(prior, dtype=float)
    scaled, scaled_prior, root = _scaled(information, start)
    flat = scaled.reshape(len(scaled), -1)
    weights = _multiplicative(flat, scaled_prior)
    chosen = np.argsort(weights)[::-1][: 3 * scaled.shape[1]]
    best, best_gap = weights, np.inf
    for _ in range(_ROUNDS):
        weights = np.zeros(len(scaled))
        weights[chosen] = _polished(scaled[chosen], scaled_prior, _solve_dual(scaled[chosen], scaled_prior))
        slopes = flat @ np.linalg.inv(_total(flat, weights, scaled_prior)).ravel()
        current = float(np.max(slopes) - weights @ slopes)
        if current < best_gap:
            best, best_gap = weights, current
        outside = np.setdiff1d(np.argsort(slopes)[::-1][:_ADDED], chosen)
        outside = outside[slopes[outside] > weights @ slopes + gap / 2]
        if current <= gap or not outside.size:
            break
        chosen = np.union1d(chosen[weights[chosen] > 0], outside)
    weights = _pruned(best)
    W = np.linalg.inv(_total(flat, weights, scaled_prior))
    slopes = flat @ W.ravel()
    order = np.argsort(weights)[::-1]
    return Design(
        weights=weights,
        dual=root.T @ W @ root,
        gap=float(np.max(slopes) - weights @ slopes),
        support=order[weights[order] > 0],
        sensitivities=slopes,
        information=information,
        prior=start,
    )


def _scaled(information: FloatArray, prior: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Change the parameters such that the mean information is the unit matrix, which does not change the optimum."""
    mean = information.mean(axis=0) + prior
    size = np.sqrt(np.diag(mean))
    if np.any(size <= 0) or np.linalg.eigvalsh(mean / np.outer(size, size))[0] < 1e-13:
        worst = int(np.argmin(size)) if np.any(size <= 0) else _weakest(mean / np.outer(size, size))
        raise InputError(
            f"no candidate position distinguishes parameter {worst + 1} of {len(mean)} from the others; "
            "leave it out of the unknown parameters, give a prior, or widen ranges and frequencies"
        )
    root = np.linalg.inv(np.linalg.cholesky(mean))
    return root @ information @ root.T, root @ prior @ root.T, root


def _weakest(matrix: FloatArray) -> int:
    """Return the parameter that counts most in the direction without information."""
    return int(np.argmax(np.abs(np.linalg.eigh(matrix)[1][:, 0])))


def _total(flat: FloatArray, weights: FloatArray, prior: FloatArray) -> FloatArray:
    total: FloatArray = prior + (weights @ flat).reshape(prior.shape)
    return total


def _multiplicative(flat: FloatArray, prior: FloatArray) -> FloatArray:
    """Make some steps of the multiplicative algorithm (Silvey, Titterington and Torsney 1978), from equal shares."""
    weights = np.full(len(flat), 1.0 / len(flat))
    for _ in range(_WARM_STEPS):
        slopes = flat @ np.linalg.inv(_total(flat, weights, prior)).ravel()
        weights = weights * slopes / (weights @ slopes)
    return weights


def _solve_dual(information: FloatArray, prior: FloatArray) -> FloatArray:
    """Solve the dual problem over some candidates; returns their shares, the multipliers of its constraints."""
    import cvxpy as cp  # here, because it loads slowly

    n = prior.shape[0]
    W, nu = cp.Variable((n, n), symmetric=True), cp.Variable()
    flat = information.reshape(len(information), -1)
    within = flat @ cp.vec(W, order="C") <= nu
    problem = cp.Problem(cp.Minimize(-cp.log_det(W) + cp.sum(cp.multiply(W, prior)) + nu), [within])
    problem.solve(solver=cp.CLARABEL)
    weights = np.maximum(np.asarray(within.dual_value, dtype=float), 0.0)
    result: FloatArray = weights / weights.sum()
    return result


def _polished(information: FloatArray, prior: FloatArray, weights: FloatArray) -> FloatArray:
    """Make Newton steps in the shares above zero, which a conic solver leaves with few correct digits."""
    weights = _pruned(weights)
    for _ in range(_NEWTON_STEPS):
        inside = np.flatnonzero(weights)
        shares, chosen = weights[inside], information[inside]
        flat = chosen.reshape(len(chosen), -1)
        W = np.linalg.inv(_total(flat, shares, prior))
        slopes = flat @ W.ravel()
        turned = (W @ chosen).transpose(0, 2, 1).reshape(len(chosen), -1)
        curvature = (W @ chosen).reshape(len(chosen), -1) @ turned.T
        bordered = np.block([[curvature, np.ones((len(chosen), 1))], [np.ones((1, len(chosen))), np.zeros((1, 1))]])
        step = np.linalg.lstsq(bordered, np.append(slopes, 0.0), rcond=None)[0][:-1]
        falling = step < 0
        length = min(1.0, float(np.min(-shares[falling] / step[falling], initial=np.inf)))
        weights[inside] = np.maximum(shares + length * step, 0.0)
        weights = _pruned(weights)
        if length == 1.0 and np.max(np.abs(step)) < 1e-12:
            break
    return weights


def _pruned(weights: FloatArray) -> FloatArray:
    kept = np.where(weights > _SUPPORT, weights, 0.0)
    result: FloatArray = kept / kept.sum()
    return result
