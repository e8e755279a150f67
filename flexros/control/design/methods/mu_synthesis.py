"""Mu synthesis by D-K iteration, for the whole spring range."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.optimize import least_squares, minimize_scalar

from flexros.control.design.continuous import ContinuousSystem, delayed_plant, tustin
from flexros.control.design.h_infinity import h_infinity
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

_FREQUENCIES = 150
"""Frequencies at which mu is computed [1] (chosen)."""
_REST = 1e-3
"""Pole of the integral weight and noise at rest, over the integral frequency and the noise [1] (chosen)."""
_APART = np.array([0.02, 0.5, -0.5])
"""Distances of zero and pole at which fits of a scaling start, over half the logarithm of the range [1] (chosen)."""


class MuSynthesis(AbstractDesignMethod):
    """Robust performance over the spring range: least structured singular value, by D-K iteration.

    The slope of the nonlinear spring is uncertain between its softest and stiffest segment, which changes the plant
    by a term of rank one. Performance: a torque at the motor [1 Nm] and encoder noise cause a weighted motor position
    stiffness (s + integral) / s q_m and a torque u / torque below 1 together. Structure: one complex number for the
    spring, one full block for performance. K step: H-infinity synthesis (python-control, SLICOT SB10AD); D step: upper
    bound of mu at each frequency and a scaling of first order fitted to it (Doyle 1985; Skogestad and Postlethwaite
    2005, section 8.12). mu below 1 means that the performance holds for every slope.
    """

    method: ClassVar[str] = "mu_synthesis"
    tunable: ClassVar[tuple[str, ...]] = ("stiffness", "integral", "torque", "noise", "spread")

    stiffness: float = Field(default=5.0, gt=0.0, description="least dynamic stiffness [Nm/rad or N/m]")
    integral: float = Field(default=3.0, gt=0.0, description="frequency below which the stiffness rises [rad/s]")
    torque: float = Field(default=2.0, gt=0.0, description="torque per torque of the disturbance that costs 1 [1]")
    noise: float = Field(
        default=1e-2,
        gt=0.0,
        description="encoder noise above the integral frequency, per 1 Nm of disturbance [rad or m]",
    )
    spread: float = Field(
        default=1.0,
        gt=0.0,
        le=1.4,
        description="uncertainty of the slope over half the range of the spring; above 1 for wrong springs [1]",
    )
    shift: float = Field(default=0.5, gt=0.0, description="shift of the poles of the design plant to the left [1/s]")
    iterations: int = Field(default=4, ge=1, le=20, description="D-K iterations [1]")

    def design(self, problem: DesignProblem) -> Design:
        """Iterate K and D steps, and keep the controller of the least peak of mu; see `AbstractDesignMethod.design`."""
        plant = self.generalised_plant(problem)
        frequency = self.frequencies(problem)
        scaling, best = ContinuousSystem.of_polynomials([1.0, 1.0], [1.0, 1.0]), None
        figures: dict[str, float] = {}
        for number in range(1, self.iterations + 1):
            controller, gamma = h_infinity(_scaled(plant, scaling), 1, 1, "mu_synthesis")
            bounds, scales = mu_bounds(closed_response(plant, controller, frequency))
            peak = float(np.max(bounds))
            figures[f"peak of mu, iteration {number}"] = peak
            if best is None or peak < best[0]:
                best = (peak, gamma, controller)
            scaling = fitted_scaling(scales, frequency)
        assert best is not None
        controller = best[2]
        error = ContinuousSystem(controller.A, -controller.B, controller.C, -controller.D)
        figures |= {"peak of mu": best[0], "gamma": best[1]}
        return Design(tustin(error, problem.sample_time), problem.sample_time, None, figures)

    def frequencies(self, problem: DesignProblem) -> FloatArray:
        """Return the frequencies of mu [Hz], shape (F,)."""
        return np.asarray(np.geomspace(self.integral / 100.0, 0.2 / problem.sample_time, _FREQUENCIES))

    def generalised_plant(self, problem: DesignProblem) -> ContinuousSystem:
        """Return the plant from [spring, disturbance, noise, torque] to [spring, position, torque, measurement]."""
        nominal = delayed_plant(problem, 0.5, "mu_synthesis")
        soft, stiff = (problem.plant_at(share) for share in (0.0, 1.0))
        left, sizes, right = np.linalg.svd(0.5 * self.spread * (stiff.A[0] - soft.A[0]))
        own, late = len(soft.A[0]), len(nominal.A) - len(soft.A[0])
        changes = sizes[0] > 1e-9  # a linear spring has no range: the channel is then empty but for its place
        entry = np.concatenate([np.zeros(late), left[:, 0] * np.sqrt(sizes[0])]) * float(changes)
        exit_ = np.concatenate([np.zeros(late), right[0] * np.sqrt(sizes[0])]) * float(changes)
        n = late + own
        A = np.zeros((n + 2, n + 2))  # the plant, the integral of its position, the filter of the noise
        A[:n, :n] = nominal.A - self.shift * np.eye(n)
        A[n, :n], A[n, n] = nominal.C[0], -_REST * self.integral
        A[n + 1, n + 1] = -self.integral
        B = np.zeros((n + 2, 4))
        B[:n, 0], B[late:n, 1], B[n + 1, 2], B[:n, 3] = entry, soft.B[0][:, 0], 1.0, nominal.B[:, 0]
        C, D = np.zeros((4, n + 2)), np.zeros((4, 4))
        C[0, :n] = exit_
        C[1, :n], C[1, n] = self.stiffness * nominal.C[0], self.stiffness * self.integral
        C[3, :n], C[3, n + 1] = nominal.C[0], self.noise * (_REST - 1.0) * self.integral
        D[2, 3], D[3, 2] = 1.0 / self.torque, self.noise
        return ContinuousSystem(A, B, C, D)


def mu_bounds(response: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the upper bounds of mu for one complex number and one full block, and the scales that give them.

    mu <= min over d of the largest singular value of diag(d, 1) M diag(1 / d, 1); with two blocks the bound is exact
    (Packard and Doyle 1993).

    Args:
        response: M, the number first, shape (F, 1 + n, 1 + n).

    Returns:
        Bounds and d, each of shape (F,).
    """
    bounds, scales = np.empty(len(response)), np.empty(len(response))
    for index, M in enumerate(response):

        def size(log: float, M: ComplexArray = M) -> float:
            scaled = M.copy()
            scaled[0, 1:] *= np.exp(log)
            scaled[1:, 0] *= np.exp(-log)
            return float(np.linalg.norm(scaled, 2))

        column, row = (max(float(np.linalg.norm(part)), 1e-12) for part in (M[1:, 0], M[0, 1:]))
        guess = 0.5 * float(np.log(column / row))
        found = minimize_scalar(size, bounds=(guess - 5.0, guess + 5.0), method="bounded", options={"xatol": 1e-6})
        bounds[index], scales[index] = float(found.fun), float(np.exp(found.x))
    return bounds, scales


def fitted_scaling(scales: FloatArray, frequency: FloatArray) -> ContinuousSystem:
    """Return gain (s + a) / (s + b), stable with stable inverse, whose magnitude fits scales best in logarithms.

    a and b lie within the frequencies: further away they are not told, and a plant with faster states is badly
    conditioned.
    """
    w = 2 * np.pi * frequency

    def difference(logs: FloatArray) -> FloatArray:
        gain, a, b = np.exp(logs)
        return np.asarray(np.log(gain * np.hypot(w, a) / np.hypot(w, b)) - np.log(scales))

    slowest, fastest = np.log([w.min(), w.max()])
    middle, half = 0.5 * (slowest + fastest), 0.5 * (fastest - slowest)
    starts = [[float(np.mean(np.log(scales))), middle + apart, middle - apart] for apart in half * _APART]
    limits = ([-40.0, slowest, slowest], [40.0, fastest, fastest])
    found = min((least_squares(difference, start, bounds=limits) for start in starts), key=lambda fit: float(fit.cost))
    gain, a, b = np.exp(found.x)
    return ContinuousSystem.of_polynomials([float(gain), float(gain * a)], [1.0, float(b)])


def closed_response(plant: ContinuousSystem, controller: ContinuousSystem, frequency: FloatArray) -> ComplexArray:
    """Return the response with u = K y closed: last input and output are those of the controller, shape (F, m, m)."""
    G, K = plant.response(frequency), controller.response(frequency)[:, 0, 0]
    share = K / (1.0 - G[:, -1, -1] * K)
    return np.asarray(G[:, :-1, :-1] + share[:, None, None] * G[:, :-1, -1:] @ G[:, -1:, :-1])


def _scaled(plant: ContinuousSystem, scaling: ContinuousSystem) -> ContinuousSystem:
    """Return the plant with its first output times d and its first input over d."""
    d = float(scaling.D[0, 0])
    inverse = ContinuousSystem(
        scaling.A - scaling.B @ scaling.C / d, scaling.B / d, -scaling.C / d, np.array([[1.0 / d]])
    )
    one = np.eye(plant.B.shape[1] - 1)
    return _beside(inverse, one).then(plant).then(_beside(scaling, one))


def _beside(first: ContinuousSystem, direct: FloatArray) -> ContinuousSystem:
    """Return a system for the first signal beside a gain for the others."""
    n, m = len(first.A), len(direct)
    B, C = np.hstack([first.B, np.zeros((n, m))]), np.vstack([first.C, np.zeros((m, n))])
    D = np.block([[first.D, np.zeros((1, m))], [np.zeros((m, 1)), direct]])
    return ContinuousSystem(first.A, B, C, D)
