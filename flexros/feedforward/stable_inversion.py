"""Feedforward by stable inversion: the bounded inverse of the complete model, also where it is non-minimum phase."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np

from flexros.errors import InputError, RunError
from flexros.feedforward.base import AbstractFeedforward
from flexros.feedforward.boundary_value.bounded_ends import at_rest_before, bounded_after
from flexros.feedforward.boundary_value.difference_equations import (
    DifferenceEquations,
    KnownMotion,
    difference_equations,
)
from flexros.feedforward.boundary_value.gear_deflection import GearDeflections, gear_deflections
from flexros.feedforward.boundary_value.newton import BoundarySolution, End, solve_boundary_problem
from flexros.feedforward.compensation.arm_forces import arm_forces
from flexros.feedforward.minimum_phase import actuation_time, minimum_phase
from flexros.feedforward.motion import Motion
from flexros.feedforward.time_stepping.dae_equations import build_equations
from flexros.feedforward.time_stepping.initial_values import consistent_initial_values
from flexros.feedforward.tool_geometry import ToolGeometry

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import FloatArray
    from flexros.feedforward.problem import FeedforwardProblem


MOST_PASSES = 50
"""Largest number of passes over the torques of coupled rotors (chosen)."""

SETTLED = 1e-6
"""Change of the deflections, over the largest, at which coupled rotors count as settled (chosen; round-off 3e-7)."""


class StableInversion(AbstractFeedforward):
    """Inverse dynamics as a boundary value problem in servo-constraint form (Drucker and Seifried, arXiv:2210.01555).

    Unknown are arm, motors and gear torques at all samples at once; what belongs to unstable zeros is bounded towards
    the future, what belongs to stable ones begins at rest. The motors therefore move before the tool (pre-actuation)
    and after it (post-actuation): the trajectory has to rest for `actuation_time` before it moves.
    """

    name: ClassVar[str] = "stable_inversion"

    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Solve all samples at once and yield them in chunks; see `AbstractFeedforward.motions`."""
        problem.require_square(problem.output)
        lead = _lead(problem)
        if problem.time[-1] < problem.trajectory.rest_before - lead:
            yield from _resting(problem).chunks(chunk)
            return
        solution = bounded_inverse(problem)
        yield from solution.motion.rows(0, problem.n_samples).chunks(chunk)


def inverts_stably(problem: FeedforwardProblem) -> bool:
    """Return whether a problem is solved by stable inversion: as its method, or where its zero dynamics are unstable.

    Args:
        problem: Robot, trajectory and settings.

    Raises:
        InputError: The output cannot be inverted.
    """
    settings = problem.specification
    if settings.method == "dae" and settings.non_minimum_phase == "stable_inversion":
        return not minimum_phase(problem)
    return settings.method == "stable_inversion"


@dataclass(frozen=True, eq=False)
class BoundedInverse:
    """Solution of the boundary value problem of a motion.

    Attributes:
        motion: Motion and torque, at least as many samples as the problem has.
        newton: Newton's iteration, the last one with inertial coupling.
    """

    motion: Motion
    newton: BoundarySolution


def bounded_inverse(problem: FeedforwardProblem) -> BoundedInverse:
    """Solve for the bounded motion of the robot whose output is the desired one.

    The grid ends later than the trajectory and the problem's last sample, by the time of the motion after the tool's.
    Rotors that act on the arm in addition to their gears (inertial coupling) do so by the motion of the pass before.

    Raises:
        InputError: The output cannot be inverted, or the motion is too long.
        RunError: No solution was found.
    """
    end = max(problem.trajectory.duration, float(problem.time[-1])) + actuation_time(problem)
    time = np.arange(ceil(end / problem.sample_time) + 1, dtype=np.float64) * problem.sample_time
    robot = problem.robot
    equations = difference_equations(robot, problem.output, problem.sample_time, problem.laws)
    gears = gear_deflections(robot, problem.sample_time)
    known = known_motion(problem, time)
    first, last = (_equilibrium(problem, equations, known, sample) for sample in (0, -1))
    ends = _ends(equations, known, first, last)
    before, guess = np.zeros(0), None
    for _ in range(MOST_PASSES):
        newton = solve_boundary_problem(equations, known, *ends, guess)
        guess = newton.unknowns
        torques = guess[:, robot.n_arm :] * equations.torque_units
        deflections = gears.along(torques[:, list(robot.flexible_motors)], first.deflections)
        rates = equations.rates(deflections)
        if not robot.spec.inertial_coupling or _settled(before, deflections):
            return BoundedInverse(_motion(equations, gears, known, guess, deflections), newton)
        known = replace(known, gear_rate=rates[0], gear_acceleration=rates[1])
        before = deflections
    raise RunError(
        f"the stable inversion of robot {robot.name} does not settle within {MOST_PASSES} passes over the torques "
        "of its rotors on the arm (inertial coupling); slow the motion down, or leave the coupling out of the model"
    )


def _ends(
    equations: DifferenceEquations, known: KnownMotion, first: _Equilibrium, last: _Equilibrium
) -> tuple[End, End]:
    """Return the conditions at start and end from the equations linearised at rest."""
    blocks = [
        equations.blocks(np.tile(rest.unknowns, (3, 1)), known.at_rest(sample))[:, 0]
        for rest, sample in ((first, 0), (last, -1))
    ]
    n_out = equations.n_out
    return End(first.unknowns, at_rest_before(blocks[0], n_out)), End(last.unknowns, bounded_after(blocks[1], n_out))


def _settled(before: FloatArray, deflections: FloatArray) -> bool:
    if not before.size:
        return not deflections.size
    return bool(np.max(np.abs(deflections - before)) <= SETTLED * np.max(np.abs(deflections)))


def _motion(
    equations: DifferenceEquations, gears: GearDeflections, known: KnownMotion, x: FloatArray, deflections: FloatArray
) -> Motion:
    """Return motion and torque of all inner samples."""
    n = equations.n_arm
    e, (e_rate, e_acceleration) = x[1:-1, :n], equations.rates(x[:, :n])
    position = known.position + e
    arguments = (
        position, known.velocity + e_rate, known.acceleration + e_acceleration,
        x[1:-1, n:] * equations.torque_units, deflections[1:-1], *equations.rates(deflections),
    )  # fmt: skip
    torque, load, momentum, motor, rate = (
        np.array(part, dtype=float).T for part in gears.motion.call([ca.DM(row.T) for row in arguments])
    )
    return Motion(position, motor, rate, torque, load, momentum)


def known_motion(problem: FeedforwardProblem, time: FloatArray) -> KnownMotion:
    """Compute the motion of the rigid arm along the trajectory, exact up to its accelerations.

    Args:
        problem: Robot, trajectory and settings.
        time: Times [s], shape (n,).
    """
    position, velocity, acceleration = (problem.arm_position(part) for part in problem.gear_motion(2, time))
    none = np.zeros((len(time), len(problem.robot.flexible_motors)))
    return KnownMotion(position, velocity, acceleration, problem.output_motion(0, time)[0], none, none)


def _lead(problem: FeedforwardProblem) -> float:
    """Return the time for which the motors move before the tool [s]; refuse a trajectory without it."""
    needed, rest = actuation_time(problem), problem.trajectory.rest_before
    if rest < needed * (1.0 - 1e-9):
        raise InputError(
            f"the stable inversion of robot {problem.robot.name} moves the motors {needed:.4g} s before the tool, but "
            f"the trajectory rests for {rest:.4g} s at its start; let it rest for at least {needed:.4g} s "
            "(hold_before of a scenario's trajectory, Trajectory.delayed in Python)"
        )
    return needed


def _resting(problem: FeedforwardProblem) -> Motion:
    """Return the motion of a problem whose samples all lie before the first motion of the motors."""
    robot = problem.robot
    equations = difference_equations(robot, problem.output, problem.sample_time, problem.laws)
    known = known_motion(problem, problem.time)
    rest = _equilibrium(problem, equations, known, 0)
    rows = problem.n_samples + 2
    gears = gear_deflections(robot, problem.sample_time)
    return _motion(equations, gears, known, np.tile(rest.unknowns, (rows, 1)), np.tile(rest.deflections, (rows, 1)))


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """Unknowns and deflections of the flexible gears at rest."""

    unknowns: FloatArray
    deflections: FloatArray


def _equilibrium(
    problem: FeedforwardProblem, equations: DifferenceEquations, known: KnownMotion, sample: int
) -> _Equilibrium:
    """Return the equilibrium with the desired output of a sample."""
    robot, n = problem.robot, problem.robot.n_arm
    geometry = ToolGeometry.of(robot, problem.laws) if problem.laws else None
    of_a_step = build_equations(robot.model, problem.output, geometry=geometry, forces=arm_forces(robot, problem.laws))
    z = consistent_initial_values(robot, of_a_step, known.output[sample], known.position[sample])
    q_a, q_m, still = z[:n], z[n : robot.n_coordinates], np.zeros(robot.n_coordinates)
    springs = robot.model.transmission_force(q_a, still[:n], q_m, still[n:], robot.model.parameter_values)
    torques = np.array(springs, dtype=float).ravel()[list(robot.gear_rows)]
    torques[list(robot.stiff_motors)] = z[robot.n_coordinates :]
    flexible = [robot.gear_rows[motor] for motor in robot.flexible_motors]
    return _Equilibrium(
        np.concatenate([q_a - known.position[sample], torques / equations.torque_units]), q_m - q_a[flexible]
    )
