"""Backward difference formulas of order 1 (backward Euler, as in Moberg 2007, Paper B, section 7) and 2."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BackwardDifference:
    """Formula h v_k = D q_k + curvature D^2 q_k with the backward differences D q_k = q_k - q_{k-1}, D^2 = D D.

    Order 2 stays convergent for equations of high index at constant step size (K. Brenan, S. Campbell, L. Petzold,
    Numerical Solution of Initial-Value Problems in Differential-Algebraic Equations, 1996, section 3.2). Its start-up
    needs no step of lower order: the motion begins at rest in equilibrium, so all earlier differences are zero.

    Attributes:
        order: Order of convergence.
        curvature: Coefficient of the second difference: 0 for order 1, 1/2 for order 2.
    """

    order: int
    curvature: float

    @property
    def leading(self) -> float:
        """Coefficient of the new value q_k, so that gamma = leading / h."""
        return 1.0 + self.curvature


FORMULAS = {1: BackwardDifference(order=1, curvature=0.0), 2: BackwardDifference(order=2, curvature=0.5)}
"""The formulas by order."""
