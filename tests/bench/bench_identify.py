"""Speed of the gray-box model compared with NumPy and SciPy's finite differences, measured in the same run.

Prints one JSON list. The case is that of the identification of six_axis: 15 positions, 200 frequencies, 6 x 6 responses
and 26 parameters. The Jacobian is exact in factored form: one number per parameter and one vector of 6 per spring and
point, whose products are its elements; written out it is 45 MB. Peers: batched NumPy, and scipy.optimize.least_squares
with finite differences of the same responses.
"""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import least_squares as scipy_least_squares

from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.identify.graybox.kernel.frequency_kernel import FrequencyKernel
from flexros.identify.graybox.kernel.frequency_model import compiled_model
from flexros.identify.graybox.kernel.structure import kernel_structure
from flexros.identify.graybox.least_squares import ResponseTarget, least_squares
from flexros.identify.graybox.multistart import multistart
from flexros.identify.graybox.numpy_least_squares import NumpyLeastSquares
from flexros.identify.graybox.problem import graybox_problem
from flexros.robot import load_robot
from flexros.robot.linear.positions import LinearisedPositions, linearise_positions
from tests.identify.graybox.conftest import measure

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flexros.arrays import ComplexArray, FloatArray

CASE = "six_axis, 15 positions x 200 frequencies, 6 x 6, 26 parameters"
FREQUENCY = np.linspace(1.0, 100.0, 200)
ESTIMATORS = (("LLSM", "user"), ("LLS", "user"), ("LLS", "optimal"), ("NLS", "user"), ("NLS", "optimal"))
STARTS = 6


def seconds(work: Callable[[], object], repeats: int = 15) -> float:
    """Return the shortest time of several runs [s]; other load on the machine only increases it."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def motor_positions() -> FloatArray:
    """Return 15 poses spread over the workspace [rad], shape (15, 6)."""
    spread: FloatArray = np.array([0, 0.2, 0.2, 0.2, 0.6, 0.3]) + np.random.default_rng(0).uniform(-0.8, 0.8, (15, 6))
    return spread


def linearisation_rows() -> Iterator[dict[str, Any]]:
    """Time the linearisation at 15 positions for new values, equilibria included."""
    robot, motors = load_robot("six_axis"), motor_positions()
    values = linearise_positions(robot, robot.spec.unknown_parameters, motors).values * 1.1
    took = seconds(lambda: linearise_positions(robot, robot.spec.unknown_parameters, motors, values))
    yield row("linearisation for new values", 1e3 * took, "ms", 30.0)


def jacobian_rows(positions: LinearisedPositions, model: FrequencyModel) -> Iterator[dict[str, Any]]:
    """Time responses and Jacobian on one core."""
    structure = kernel_structure(positions)
    yield row("compile once per structure", seconds(lambda: FrequencyKernel(structure), 2), "s")
    compiled, theta = compiled_model(model), positions.values
    assert compiled is not None
    took = seconds(lambda: compiled.factored_jacobian(theta), 60)
    yield row("responses and exact Jacobian", 1e3 * took, "ms", 4.0)
    written_out = seconds(lambda: (compiled.response(theta), compiled.jacobian(theta)), 3)
    yield row("the same, Jacobian written out", 1e3 * written_out, "ms")
    plain = seconds(lambda: model.response_and_jacobian(theta), 3)
    yield row("responses and exact Jacobian, NumPy", 1e3 * plain, "ms")
    peer = finite_difference_seconds(model.response, theta)
    yield row("one iteration by SciPy finite differences", 1e3 * peer, "ms")
    yield row("times faster than SciPy finite differences", peer / took, "1")
    peer = finite_difference_seconds(compiled.response, theta)
    yield row("one iteration by SciPy finite differences of the compiled responses", 1e3 * peer, "ms")


def finite_difference_seconds(response: Callable[[FloatArray], ComplexArray], theta: FloatArray) -> float:
    """Time the errors and their Jacobian of one iteration of SciPy's least squares [s]."""
    measured = response(theta)

    def errors(x: FloatArray) -> FloatArray:
        return np.log(response(np.exp(x)) / measured).ravel().view(np.float64)

    return seconds(lambda: scipy_least_squares(errors, np.log(theta), jac="2-point", max_nfev=1), 1)


def normal_equation_rows(model: FrequencyModel) -> Iterator[dict[str, Any]]:
    """Time cost, gradient and Gauss-Newton Hessian on one and two threads."""
    rng = np.random.default_rng(0)
    theta = model.positions.values
    response = model.response(theta)
    measured = response * np.exp(0.1 * rng.normal(size=response.shape))
    for estimator in ("LLS", "LLSM", "NLS"):
        target = ResponseTarget(measured, np.ones(measured.shape), estimator)
        for threads in (1, 2):
            took = iteration_seconds(model, target, threads)
            yield row(f"normal equations {estimator}, {threads} threads", 1e3 * took, "ms", 5.0)
    plain = seconds(lambda: NumpyLeastSquares(model, target).normal_equations(theta), 2)
    yield row("normal equations NLS, NumPy", 1e3 * plain, "ms")


def iteration_seconds(model: FrequencyModel, target: ResponseTarget, threads: int) -> float:
    """Time the normal equations at ever new parameters [s]."""
    squares, values = least_squares(model, target, threads), model.positions.values
    points = iter([values * (1 + 1e-3 * step) for step in range(40)])
    return seconds(lambda: squares.normal_equations(next(points)), 30)


def fit_rows() -> Iterator[dict[str, Any]]:
    """Time fits from random starts within a factor of ten, on two threads."""
    robot = load_robot("six_axis")
    responses = measure(robot, motor_positions(), FREQUENCY, noise=0.01, seed=1)
    problem = graybox_problem(robot, responses)
    begin = time.perf_counter()
    for estimator, weights in ESTIMATORS:
        multistart(problem.with_choice(estimator, weights), STARTS, seed=2, threads=2)
    each = (time.perf_counter() - begin) / (STARTS * len(ESTIMATORS))
    yield row(f"600 fits on two threads, from {STARTS * len(ESTIMATORS)} of them", 600 * each, "s", 60.0)


def row(what: str, value: float, unit: str, goal: float | None = None) -> dict[str, Any]:
    """Return one row of the results."""
    return {"case": CASE, "what": what, "value": float(f"{value:.4g}"), "unit": unit, "goal": goal}


def main() -> None:
    """Print all rows."""
    robot = load_robot("six_axis")
    positions = linearise_positions(robot, robot.spec.unknown_parameters, motor_positions())
    model = FrequencyModel(positions, FREQUENCY, robot.sample_time, robot.delay)
    parts = (linearisation_rows(), jacobian_rows(positions, model), normal_equation_rows(model), fit_rows())
    print(json.dumps([one for part in parts for one in part], indent=1))


if __name__ == "__main__":
    main()
