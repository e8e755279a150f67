"""Static friction laws of Moberg (2007), equations 3.14 to 3.16, and their fit to measured points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.identify.friction.points import FrictionPoints

STARTS = 20
"""Random initial values of a fit (chosen)."""


@dataclass(frozen=True)
class FrictionLaw:
    """A friction torque as a function of the speed.

    Attributes:
        name: Its name.
        equation: Its number in the thesis.
        parameters: Names of its parameters, all positive.
        evaluate: (speed, parameters) -> torque.
    """

    name: str
    equation: str
    parameters: tuple[str, ...]
    evaluate: Callable[[FloatArray, FloatArray], FloatArray]


def coulomb(speed: FloatArray, p: FloatArray) -> FloatArray:
    """Return viscous and Coulomb friction, f_v v + f_c sign(v)."""
    return np.asarray(p[0] * speed + p[1] * np.sign(speed))


def lugre(speed: FloatArray, p: FloatArray) -> FloatArray:
    """Return LuGre friction in steady sliding, f_v v + (f_c + (f_s - f_c) exp(-(v / v_s)^2)) sign(v)."""
    return np.asarray(p[0] * speed + (p[1] + p[2] * np.exp(-((speed / p[3]) ** 2))) * np.sign(speed))


def feeny_moon(speed: FloatArray, p: FloatArray) -> FloatArray:
    """Return smooth friction, f_v v + f_c (mu_k + (1 - mu_k) / cosh(beta v)) tanh(alpha v) (Feeny and Moon 1994).

    The equation prints cosh^-1; it means 1 / cosh.
    """
    f_v, f_c, mu_k, beta, alpha = p
    arch = 1.0 / np.cosh(np.clip(beta * speed, -300.0, 300.0))
    return np.asarray(f_v * speed + f_c * (mu_k + (1.0 - mu_k) * arch) * np.tanh(alpha * speed))


LAWS = (
    FrictionLaw("viscous and Coulomb", "3.14", ("f_v", "f_c"), coulomb),
    FrictionLaw("LuGre, steady", "3.15", ("f_v", "f_c", "f_s_less_f_c", "v_s"), lugre),
    FrictionLaw("Feeny and Moon", "3.16", ("f_v", "f_c", "mu_k", "beta", "alpha"), feeny_moon),
)
"""From poor to rich."""


@dataclass(frozen=True, eq=False)
class FrictionFit:
    """A law fitted to points.

    Attributes:
        law: The law.
        values: Its parameters in SI units, shape (n_p,).
        deviations: Their standard deviations; infinite where the points do not determine them, shape (n_p,).
        rms: Root mean square of the residuals [Nm or N].
        criterion: Bayesian information criterion: the law with the lowest explains the points best.
    """

    law: FrictionLaw
    values: FloatArray
    deviations: FloatArray
    rms: float
    criterion: float


def fit_law(law: FrictionLaw, points: FrictionPoints, seed: int = 1) -> FrictionFit:
    """Fit a law by least squares from several initial values.

    Args:
        law: The law.
        points: Speeds and torques, more than the law has parameters.
        seed: Seed of the initial values.

    Raises:
        InputError: Too few points.
    """
    from scipy.optimize import least_squares  # loads slowly

    n, number = len(points.speed), len(law.parameters)
    if n <= number:
        raise InputError(
            f"{n} constant speeds were measured, but the law '{law.name}' has {number} parameters; measure more speeds"
        )
    fastest, strongest = float(np.abs(points.speed).max()), float(np.abs(points.torque).max())
    if strongest == 0:
        raise InputError("the torques at all constant speeds are zero, so there is no friction to fit; record torques")
    scales = {"f_v": strongest / fastest, "f_c": strongest, "f_s_less_f_c": strongest, "v_s": fastest, "mu_k": 1.0}
    scale = np.array([scales.get(name, 1.0 / fastest) for name in law.parameters])
    widest = np.array([{"mu_k": 1.0}.get(name, {"beta": 1e3, "alpha": 1e5}.get(name, 1e2)) for name in law.parameters])
    rng = np.random.default_rng(seed)

    def residuals(x: FloatArray) -> FloatArray:
        return (law.evaluate(points.speed, x * scale) - points.torque) / strongest

    best = None
    for _ in range(STARTS):
        start = np.minimum(10.0 ** rng.uniform(-2, 0, number) * np.where(widest > 1e2, 1e2, 1.0), 0.9 * widest)
        found = least_squares(residuals, start, bounds=(1e-9, widest), x_scale="jac")
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    square = 2.0 * best.cost / (n - number)
    information = best.jac.T @ best.jac
    determined = np.linalg.eigvalsh(information)[0] > 1e-12 * np.linalg.norm(information)
    deviations = np.sqrt(square * np.diag(np.linalg.inv(information))) if determined else np.full(number, np.inf)
    rms = strongest * float(np.sqrt(2.0 * best.cost / n))
    criterion = n * float(np.log(max(2.0 * best.cost / n, 1e-30))) + number * float(np.log(n))
    return FrictionFit(law, best.x * scale, deviations * scale, rms, criterion)
