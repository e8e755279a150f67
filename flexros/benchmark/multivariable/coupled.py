"""PID of all motors together, with full gain matrices and a section per motor, for the multivariable benchmark."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import block_diag

from flexros.benchmark.models import NOMINAL, RULES
from flexros.benchmark.multivariable.evaluate import NOISE_SHARE, SETTLED
from flexros.benchmark.optimise import MISSED, ROOM, UNSTABLE, minimised
from flexros.control.base import control_law
from flexros.control.design.fixed_structure import DiscreteSystem, biquad_system
from flexros.errors import FlexrosError, InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.benchmark.multivariable.evaluate import MotionBenchmark

START = {"e12": ((9.0, 6.0), (1.2, 0.9), (1.9, 1.1), 5e-3)}
"""First bandwidth [rad/s], damping ratio [1], integral over proportional gain [1/s] of each motor, and filter [s]: the
fastest PID of each motor by itself (chosen). An arm of six axes has 133 numbers, too many for this search."""
SECTION = (40.0, 0.5, 40.0, 0.5)
"""First second-order section of each motor, see `biquad_system`: it does nothing (chosen)."""
LINEAR_SHARE = 20
"""Linear loops that are tried per run of all models [1] (chosen): one takes some milliseconds."""
FIRST_STEP, SECOND_STEP = 0.15, 0.05
"""First standard deviations of the two searches [1] (chosen)."""
PEAKS = 7.0
"""Peak-to-peak of white noise at rest over its standard deviation [1] (chosen)."""
SHORTEST = 1e-3
"""Shortest time constant of the derivative [s] (chosen)."""


def coupled_pid(
    proportional: FloatArray, integral: FloatArray, derivative: FloatArray, filtered: float, step: float
) -> DiscreteSystem:
    """Return the PID u = Kp e + Ki int e + Kd e' of several errors, as the law `pid` discretises it.

    Args:
        proportional: Kp [Nm/rad], shape (M, M).
        integral: Ki [Nm/(rad s)], shape (M, M).
        derivative: Kd [Nms/rad], shape (M, M).
        filtered: Time constant of the derivative [s].
        step: Sample time [s].
    """
    keep, rate, one = filtered / (filtered + step), 1.0 / (filtered + step), np.eye(len(proportional))
    A = np.asarray(np.kron(np.diag([keep, 1.0]), one), dtype=float)
    B = np.vstack([rate * (keep - 1.0) * one, step * one])
    return DiscreteSystem(A, B, np.hstack([derivative, integral]), proportional + rate * derivative + step * integral)


def settings_of_coupled(bench: MotionBenchmark, point: FloatArray) -> dict[str, Any]:
    """Return the settings of the law `state_space` at a point of the search.

    Args:
        bench: The benchmark.
        point: Entries of Kp, Ki and Kd over those of the start, all row by row, the logarithm of the filter over that
            of the start, and those of the sections, motor by motor, shape (3 M^2 + 1 + 4 M,).
    """
    robot, step = bench.problem.robot, bench.sample_time
    bandwidth, damping, integral, filtered = (np.array(each) for each in START[bench.problem.name])
    proportional = bandwidth**2 * bench.problem.inertia
    first = np.array([proportional, integral * proportional, 2.0 * damping / bandwidth * proportional])
    m = robot.n_motors
    gains = point[: 3 * m * m].reshape(3, m, m) * np.sqrt(first[:, :, None] * first[:, None, :])
    gains = np.vectorize(lambda value: float(f"{value:.4g}"))(gains)
    system = coupled_pid(gains[0], gains[1], gains[2], max(float(filtered * np.exp(point[3 * m * m])), SHORTEST), step)
    sections = np.array(SECTION) * np.exp(point[3 * m * m + 1 :].reshape(m, 4))
    system = system.then(_separate([biquad_system(a, b, c, d, step) for a, b, c, d in sections.tolist()]))
    matrices = {name: getattr(system, name).tolist() for name in "ABCD"}
    return {"kind": "state_space", **matrices, "matrices_sample_time": step}


def _separate(systems: Sequence[DiscreteSystem]) -> DiscreteSystem:
    """Return systems with an input and an output of their own each."""
    A, B, C, D = (np.asarray(block_diag(*(getattr(one, name) for one in systems))) for name in "ABCD")
    return DiscreteSystem(A, B, C, D)


def tuned_coupled(
    bench: MotionBenchmark, evaluations: int, tell: Callable[[int, float], None] | None = None
) -> dict[str, dict[str, Any]]:
    """Tune the coupled PID: C1 on the nominal model, C2 on all models.

    Args:
        bench: The benchmark on the models of the design.
        evaluations: Number of laws that the second search of each tries, see `tuned_on`.
        tell: Called with the number of laws and the lowest cost.

    Returns:
        Settings of the best laws, nominal and perturbed.

    Raises:
        InputError: The robot has no first values, or the package cma is missing.
    """
    if bench.problem.name not in START:
        raise InputError(f"coupled_pid has no first values for {bench.problem.name}; there are {', '.join(START)}")
    parts = {"nominal": (NOMINAL,), "perturbed": tuple(RULES)}
    return {part: tuned_on(bench, sets, evaluations, tell) for part, sets in parts.items()}


def tuned_on(
    bench: MotionBenchmark,
    sets: Sequence[str],
    evaluations: int,
    tell: Callable[[int, float], None] | None = None,
) -> dict[str, Any]:
    """Tune the coupled PID on model sets: first the slowest motion of their linear loops, then the cost V.

    The first search maximises the decay of the slowest motion over the first two sets, vibration or integral action,
    with the noise of the encoders within its demand. The second one starts from there, and charges `MISSED` per second
    or per cent beyond the demands on settling and noise, with `ROOM` to spare.

    Args:
        bench: The benchmark on the models of the design.
        sets: Names of the model sets.
        evaluations: Number of laws that the second search tries; the first one tries `LINEAR_SHARE` times as many.
        tell: Called with the number of laws and the lowest cost.

    Returns:
        Settings of the best law.

    Raises:
        InputError: The package cma is missing.
    """
    robot = bench.problem.robot
    one, m = np.eye(robot.n_motors).ravel(), robot.n_motors
    start = np.concatenate([one, one, one, np.zeros(1 + 4 * m)])
    share = 100.0 * PEAKS / np.array(bench.problem.torque)
    linear = tuple(sets[:2])

    def slowest(point: FloatArray) -> float:
        settings = settings_of_coupled(bench, point)
        direct = np.linalg.norm(np.array(settings["D"]) * robot.encoder_noise, axis=1)
        noisy = max(float(np.max(share * direct)) - (1.0 - ROOM) * NOISE_SHARE, 0.0)
        demands = bench.stability(control_law(settings), "", linear)
        beyond = sum(max(demand.value - 1.0, 0.0) for demand in demands)
        rate = np.log(max(demand.value for demand in demands[: len(linear)])) / bench.sample_time
        return float(rate + noisy + UNSTABLE * beyond)

    def cost(point: FloatArray) -> float:
        return cost_with_demands(bench, settings_of_coupled(bench, point), sets)

    first = minimised(slowest, start, FIRST_STEP, LINEAR_SHARE * evaluations)
    best = minimised(cost, first.point, SECOND_STEP, evaluations, progress=tell)
    return settings_of_coupled(bench, best.point)


def cost_with_demands(bench: MotionBenchmark, settings: dict[str, Any], sets: Sequence[str]) -> float:
    """Return the share of V of some model sets with a law, with penalties for missed demands."""
    try:
        law = control_law(settings)
        beyond = sum(max(demand.value - 1.0, 0.0) for demand in bench.stability(law, "", sets))
        if not beyond < 1.0:
            return 1e2 * UNSTABLE
        if beyond > 0.0:
            return UNSTABLE * (1.0 + 100.0 * beyond)
        value = 0.0
        for name in sets:
            found = bench.measures_of_set(name, law)
            late = float(np.sum(np.maximum(found.settling - (1.0 - ROOM) * SETTLED, 0.0)))
            noisy = max(found.noise_torque - (1.0 - ROOM) * NOISE_SHARE, 0.0)
            value += RULES[name].weight * found.cost + MISSED * (late + noisy)
    except FlexrosError:
        return 1e2 * UNSTABLE
    return value if np.isfinite(value) else 1e2 * UNSTABLE
