"""Feedforward by the DAE of Moberg (2007), Paper B: inverse dynamics of the complete model."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

from flexros.errors import RunError
from flexros.feedforward.base import AbstractFeedforward
from flexros.feedforward.compensation.arm_forces import arm_forces
from flexros.feedforward.minimum_phase import require_minimum_phase
from flexros.feedforward.motion import Motion
from flexros.feedforward.stable_inversion import StableInversion, inverts_stably
from flexros.feedforward.time_stepping.compiled import CompiledStepper
from flexros.feedforward.time_stepping.dae_equations import DaeEquations, build_equations
from flexros.feedforward.time_stepping.initial_values import consistent_initial_values
from flexros.feedforward.time_stepping.interpreted import InterpretedStepper
from flexros.feedforward.time_stepping.step_functions import StepFunctions
from flexros.feedforward.time_stepping.stepping import MAX_ITERATIONS, Stepper, newton_tolerance
from flexros.feedforward.tool_geometry import ToolGeometry

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.effects import PlacedLaw
    from flexros.feedforward.problem import FeedforwardProblem
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.robot import Robot


class DaeFeedforward(AbstractFeedforward):
    """Equations 8a to 8d integrated by a backward difference formula; the torque follows from equation 2b.

    Order 1 is backward Euler as published. Order 2 is the two-step formula with the torque averaged over the time in
    which it is held: either alone leaves an error of first order in the sample time (see docs/decisions). Each step
    solves the constraint Z = Gamma(q_a) itself, so there is no constraint drift. Where the zero dynamics are unstable,
    `StableInversion` takes its place, or the problem is refused, as its settings say.
    """

    name: ClassVar[str] = "dae"

    def compensates_hold(self, specification: FeedforwardSpecification) -> bool:
        """Return whether the mean torque is the default: not for order 1, which is as published."""
        return specification.order > 1

    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Solve the samples in order; see `AbstractFeedforward.motions`."""
        robot, settings = problem.robot, problem.specification
        problem.require_square(problem.output)
        if inverts_stably(problem):
            yield from StableInversion().motions(problem, chunk)
            return
        require_minimum_phase(problem)
        equations, gamma, stepper = dae_stepper(
            robot, problem.output, settings.order, problem.sample_time, settings.compiled, problem.laws
        )
        initial = consistent_initial_values(robot, equations, problem.desired[0], problem.rigid_start)
        tolerance = newton_tolerance(equations, gamma, initial)
        state = stepper.layout.at_rest(initial)
        for first in range(0, problem.n_samples, chunk):
            outputs = problem.desired[first : first + chunk]
            result = stepper.advance(state, outputs, tolerance)
            if result.failed < len(outputs):
                raise RunError(_failure(problem, first + result.failed))
            state = result.state
            torque, load, momentum, position, velocity = result.motors.transpose(1, 0, 2)
            yield Motion(result.z[:, : robot.n_arm], position, velocity, torque, load, momentum)


@lru_cache(maxsize=16)
def dae_stepper(
    robot: Robot,
    output: str,
    order: int,
    sample_time: float,
    compiled: bool,
    laws: tuple[PlacedLaw, ...] = (),
) -> tuple[DaeEquations, float, Stepper]:
    """Return the stepper of a robot; it is built once and cached.

    Args:
        robot: The robot.
        output: Name of the controlled output.
        order: Order of the backward difference formula, 1 or 2.
        sample_time: Step size [s].
        compiled: Whether to use machine code; otherwise the CasADi virtual machine.
        laws: Laws of effects that are part of the arm's equations.

    Returns:
        Equations of a step, leading coefficient gamma [1/s], and the stepper.
    """
    geometry = ToolGeometry.of(robot, laws) if laws else None
    equations = build_equations(robot.model, output, geometry=geometry, forces=arm_forces(robot, laws))
    functions = StepFunctions.of(equations, order, sample_time)
    stepper: Stepper = CompiledStepper(equations, functions) if compiled else InterpretedStepper(equations, functions)
    return equations, functions.gamma, stepper


def _failure(problem: FeedforwardProblem, sample: int) -> str:
    return (
        f"the dae feedforward of robot {problem.robot.name} found no solution at "
        f"{problem.trajectory.place(float(problem.time[sample]))}: Newton's iteration did not converge within "
        f"{MAX_ITERATIONS} iterations, because the path leaves the workspace, passes a singularity or is not smooth "
        "enough there; move or smooth the path"
    )
