"""Tuning of the built-in designs of the multivariable benchmark on random models of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import minimize

from flexros.benchmark.models import NOMINAL
from flexros.benchmark.multivariable.coupled import tuned_coupled
from flexros.benchmark.multivariable.evaluate import NOISE_SHARE, SETTLED, MotionBenchmark
from flexros.benchmark.multivariable.problem import SEED_OF_DESIGN
from flexros.control.base import control_law
from flexros.errors import FlexrosError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.benchmark.multivariable.problem import Problem
    from flexros.control.base import AbstractControlLaw

COUPLED = "coupled_pid"
"""Name of the PID of all motors together."""
LATE, NOISY = 200.0, 20.0
"""Cost of a second beyond the demand on settling, and of a per cent beyond that on noise (chosen)."""
UNSTABLE = 1e4
"""Cost of a law that is unstable where it must not be [1]."""
STARTS: dict[str, dict[str, tuple[float, ...]]] = {
    "pid": {"e12": (8.0, 1.4, 0.35, 5e-3), "six_axis": (21.0, 1.35, 0.15, 3e-3)},
    "cascade": {"e12": (8.0, 1.4, 0.2, 3e-3), "six_axis": (21.0, 1.35, 0.15, 3e-3)},
    "lqg": {"e12": (3000.0, 3000.0, 3e4, 1.0), "six_axis": (3000.0, 3000.0, 3e4, 1.0)},
}
"""First values of the numbers that are tuned (chosen): see `settings_of`."""


def settings_of(problem: Problem, kind: str, numbers: FloatArray) -> dict[str, Any]:
    """Return the settings of a law from the numbers that are tuned.

    Args:
        problem: The problem.
        kind: pid or cascade, with bandwidth w [rad/s], damping ratio, integral gain over w of every axis with its
            inertia J at home, and time constant of the filter of the rate [s]; or lqg, with the torque that costs one
            unit, the white torque, the drift of the torque, and the white force over the white torque.
        numbers: The numbers, shape (4,).
    """
    first, second, third, last = (float(f"{value:.4g}") for value in numbers)
    if kind == "lqg":
        force = float(f"{second * last:.4g}")
        return {"kind": "lqg", "effort": first, "torque_noise": second, "force_noise": force, "torque_drift": third}
    inertia = problem.inertia
    kp, kd = first**2 * inertia, 2 * second * first * inertia
    if kind == "pid":
        gains = {"kp": kp, "ki": third * first * kp, "kd": kd}
        return {"kind": "pid", **_rounded(gains), "derivative_filter": last}
    gains = {"position_gain": kp / kd, "speed_gain": kd, "integral_gain": third * first * kd}
    return {"kind": "cascade", **_rounded(gains), "speed_filter": last}


def tuned(
    problem: Problem, kind: str, evaluations: int = 40, tell: Callable[[int, float], None] | None = None
) -> dict[str, Any]:
    """Minimise the cost on the nominal model and the set M1 of other random models than those of the benchmark.

    What exceeds the demands on settling and noise is added to the cost with the factors `LATE` and `NOISY`; an unstable
    loop costs `UNSTABLE` and more, the more it is.

    Args:
        problem: The problem.
        kind: pid, cascade, lqg, or coupled_pid, see `tuned_coupled`.
        evaluations: Largest number of evaluations.
        tell: Called with the number of the evaluation and its cost.

    Returns:
        Settings of the best law; of coupled_pid those of C1 and C2, by nominal and perturbed.
    """
    bench = MotionBenchmark(problem, seed=SEED_OF_DESIGN)
    if kind == COUPLED:
        return tuned_coupled(bench, evaluations, tell)
    start = np.log(np.array(STARTS[kind][problem.name]))
    done = 0

    def cost(logarithms: FloatArray) -> float:
        nonlocal done
        done += 1
        try:
            value = _cost(bench, control_law(settings_of(problem, kind, np.exp(logarithms))))
        except FlexrosError:
            value = UNSTABLE
        if tell is not None:
            tell(done, value)
        return value

    simplex = np.vstack([start, *(start + 0.4 * row for row in np.eye(len(start)))])
    options = {"maxfev": evaluations, "initial_simplex": simplex, "xatol": 0.01, "fatol": 0.05}
    best = minimize(cost, start, method="Nelder-Mead", options=options)
    return settings_of(problem, kind, np.exp(best.x))


def _cost(bench: MotionBenchmark, law: AbstractControlLaw) -> float:
    """Return the cost of a law on the models of the design, with what exceeds the demands."""
    beyond = sum(max(demand.value - 1.0, 0.0) for demand in bench.stability(law))
    if beyond > 0.0:
        return UNSTABLE * (1.0 + 100.0 * beyond)
    value = 0.0
    for name, weight in ((NOMINAL, 0.6), ("M1", 1.3)):
        found = bench.measures_of_set(name, law)
        value += weight * found.cost
        value += NOISY * max(found.noise_torque - NOISE_SHARE, 0.0)
        value += LATE * float(np.sum(np.maximum(found.settling - SETTLED, 0.0)))
    return value


def _rounded(gains: dict[str, FloatArray]) -> dict[str, list[float]]:
    return {key: [float(f"{value:.4g}") for value in values] for key, values in gains.items()}
