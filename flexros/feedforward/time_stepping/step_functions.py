"""Difference formulas, and the arithmetic of one time step as CasADi functions, for both steppers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.feedforward.time_stepping.dense_function import dense_function

if TYPE_CHECKING:
    from flexros.feedforward.time_stepping.dae_equations import DaeEquations


@dataclass(frozen=True)
class BackwardDifference:
    """Backward difference formula h v_k = D q_k + curvature D^2 q_k, with D q_k = q_k - q_{k-1} and D^2 = D D.

    Order 1 is backward Euler (Moberg 2007, Paper B, section 7). Order 2 stays convergent for equations of high index at
    constant step size (K. Brenan, S. Campbell, L. Petzold, Numerical Solution of Initial-Value Problems in
    Differential-Algebraic Equations, 1996, section 3.2). It needs no start-up step of lower order: the motion begins at
    rest in equilibrium, so all earlier differences are zero.

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


@dataclass(frozen=True)
class StepFunctions:
    """Functions of one step for one order and step size; all vectors are columns.

    `differences` are z and its first three backward differences, one after the other, shape (4 n_unknowns,); `rates`
    are v and its first difference, shape (2 n_coordinates,); `prediction` is [z_0, v_0, a_0].

    Attributes:
        predict: (differences, rates) -> prediction, and x = 0 as initial value.
        residual: (x, prediction, Z) -> residual of the step.
        newton_matrix: (x, prediction) -> its derivative by x.
        correct: (x, correction, inverse tolerance) -> x - correction, and the size of the correction: the sum of its
            magnitudes in units of the tolerance (a sum propagates NaN, a maximum would lose it).
        finish: (x, prediction, differences, rates) -> differences and rates after the step, z, and the results of
            `DaeEquations.motion` from u on, one after the other, shape (5 M,).
        gamma: Leading coefficient of the difference formula over the step size [1/s].
    """

    predict: ca.Function
    residual: ca.Function
    newton_matrix: ca.Function
    correct: ca.Function
    finish: ca.Function
    gamma: float

    @classmethod
    def of(cls, equations: DaeEquations, order: int, sample_time: float) -> StepFunctions:
        """Build the functions for an order and a step size.

        Args:
            equations: One step of the DAE.
            order: Order of the backward difference formula, 1 or 2.
            sample_time: Step size h [s].

        Returns:
            The functions.
        """
        formula = FORMULAS[order]
        gamma = formula.leading / sample_time
        nz, nq = equations.n_unknowns, equations.n_coordinates
        differences, rates = ca.SX.sym("differences", 4 * nz), ca.SX.sym("rates", 2 * nq)
        x, prediction = ca.SX.sym("x", nz), ca.SX.sym("prediction", nz + 2 * nq)
        split = (prediction[:nz], prediction[nz : nz + nq], prediction[nz + nq :])
        Z = ca.SX.sym("Z", equations.n_motors)
        # the correction x is added last to z and to each difference, so all of them are predicted from the third
        # difference of the step before, held constant
        second = differences[2 * nz : 3 * nz] + differences[3 * nz :]
        first = differences[nz : 2 * nz] + second
        v_0 = (first + formula.curvature * second)[:nq] / sample_time
        change = v_0 - rates[:nq]
        a_0 = (change + formula.curvature * (change - rates[nq:])) / sample_time
        guess = ca.vertcat(differences[:nz] + first, v_0, a_0)
        v, *motion = equations.motion(x, *split, gamma)
        z = split[0] + x
        after = ca.vertcat(z, first + x, second + x, differences[3 * nz :] + x)
        correction, scale = ca.SX.sym("correction", nz), ca.SX.sym("scale", nz)
        weight = 1.0 / gamma**2
        return cls(
            predict=dense_function("predict", [differences, rates], [guess, ca.SX.zeros(nz)]),
            residual=dense_function("residual", [x, prediction, Z], [equations.residual(x, *split, gamma, weight, Z)]),
            newton_matrix=dense_function(
                "matrix", [x, prediction], [equations.newton_matrix(x, *split, gamma, weight)]
            ),
            correct=dense_function(
                "correct", [x, correction, scale], [x - correction, ca.dot(ca.fabs(correction), scale)]
            ),
            finish=dense_function(
                "finish",
                [x, prediction, differences, rates],
                [after, ca.vertcat(v, v - rates[:nq]), z, ca.vertcat(*motion)],
            ),
            gamma=gamma,
        )
