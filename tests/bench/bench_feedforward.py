"""Speed of the DAE feedforward compared with SciPy and the CasADi virtual machine, measured in the same run.

Prints one JSON list. Peers: fsolve with finite differences on equations 8a and 8d, as published; CasADi's
own Newton solver inside its virtual machine; and the index-1 form (7a to 7d, 7h) by LSODA, whose output drifts.

E12 with every body cut into 20 pieces has 60 arm coordinates. On its tool it is computed without the check of the zero
dynamics: bending makes it non-minimum phase, with unstable zeros so fast (1e4 1/s) that the difference formulas damp
them at this sample time. On its gear coordinates it is minimum phase.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from scipy.optimize import fsolve

from flexros.config.settings import validate
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.reference import compute_reference
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.feedforward.time_stepping.compiled import CompiledStepper
from flexros.feedforward.time_stepping.dae_equations import DaeEquations, arm_residual, build_equations
from flexros.feedforward.time_stepping.initial_values import consistent_initial_values
from flexros.feedforward.time_stepping.interpreted import InterpretedStepper
from flexros.feedforward.time_stepping.step_functions import StepFunctions
from flexros.feedforward.time_stepping.stepping import SteppingResult, newton_tolerance
from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory, TrajectorySpecification, build_trajectory
from tests.feedforward.cases import subdivided_e12
from tests.oracles.index_one import output_drift, solve_index_one

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

T = 5e-4
GOAL_US = {"e12": 0.6, "six_axis": 15.0}
PIECES = 20
CIRCLE = {
    "path": {"type": "circle", "centre_from_start": [-0.025, 0]},
    "time_law": {"type": "ninth_degree", "duration": 0.8},
}
JOINTS = {
    "path": {"type": "joint_moves", "points_from_start": [[0.5, 0.2, -0.2, 0.4, 0.3, 0.6]]},
    "time_law": {"type": "ninth_degree", "duration": 0.8},
}


@dataclass(frozen=True, eq=False)
class Case:
    """A robot on a path of 0.8 s."""

    name: str
    robot: Robot
    trajectory: Trajectory
    output: str

    @classmethod
    def e12(cls, robot: Robot, name: str, output: str = "tool") -> Case:
        start = robot.forward_kinematics(robot.home)
        return cls(
            name,
            robot,
            build_trajectory(validate(TrajectorySpecification, CIRCLE, "bench"), start, output="tool"),
            output,
        )

    @classmethod
    def six_axis(cls) -> Case:
        robot = load_robot("six_axis")
        start = robot.home[list(robot.gear_rows)]
        return cls(
            "six_axis", robot, build_trajectory(validate(TrajectorySpecification, JOINTS, "bench"), start), "joints"
        )

    @cached_property
    def problem(self) -> FeedforwardProblem:
        specification = FeedforwardSpecification(output=self.output)
        return FeedforwardProblem(self.robot, self.trajectory, specification, T, 1601)

    @cached_property
    def equations(self) -> DaeEquations:
        return build_equations(self.robot.model, self.output)

    @cached_property
    def start(self) -> FloatArray:
        return consistent_initial_values(self.robot, self.equations, self.problem.desired[0], self.problem.rigid_start)


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest time of several runs [s]; other load on the machine only increases it."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def stepper_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time the compiled stepper of both orders, and its compilation."""
    desired = case.problem.desired
    for order in (1, 2):
        begin = time.perf_counter()
        equations = build_equations(case.robot.model, case.output)
        functions = StepFunctions.of(equations, order, T)
        stepper = CompiledStepper(equations, functions)
        made = time.perf_counter() - begin
        tolerance = newton_tolerance(equations, functions.gamma, case.start)
        state = stepper.layout.at_rest(case.start)

        def run(
            stepper: CompiledStepper = stepper, state: FloatArray = state, tolerance: FloatArray = tolerance
        ) -> SteppingResult:
            return stepper.advance(state, desired, tolerance)

        result = run()
        assert result.failed == len(desired)
        took = seconds(run, 15)
        n = len(desired)
        drift = output_drift(case.robot, case.output, result.z[:, : case.robot.n_arm], desired)
        yield row(case.name, f"DAE step, order {order}", 1e6 * took / n, "us", GOAL_US.get(case.name))
        yield row(case.name, f"Newton iterations per step, order {order}", float(result.iterations.mean()), "1")
        yield row(case.name, f"drift of the output over {n} steps, order {order}", drift, "m or rad")
        yield row(case.name, f"equations and machine code made, order {order}", made, "s")


def reference_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time a whole reference with all parts: zero dynamics, start, stepper, hold, tool pose, compiled already."""
    specification = FeedforwardSpecification(output=case.output)

    def run() -> object:
        return compute_reference(case.robot, case.trajectory, specification, T, 0.8)

    run()
    yield row(case.name, "whole reference of 1601 samples, order 2", 1e3 * seconds(run, 3), "ms")


def interpreted_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time the same stepping by Python and the virtual machine: the fallback."""
    functions = StepFunctions.of(case.equations, 1, T)
    stepper = InterpretedStepper(case.equations, functions)
    tolerance = newton_tolerance(case.equations, functions.gamma, case.start)
    n = 400 if case.name == "e12" else 100
    took = seconds(lambda: stepper.advance(stepper.layout.at_rest(case.start), case.problem.desired[:n], tolerance), 2)
    yield row(case.name, "DAE step, order 1, interpreted fallback", 1e6 * took / n, "us")


def plain_residual(case: Case) -> ca.Function:
    """(q, q before, v before, Z) -> equations 8a and 8d with v = (q - q before) / T; arm's rows divided by gamma^2."""
    model = case.robot.model
    q, before, speed = (ca.SX.sym(name, model.n_coordinates) for name in ("q", "before", "speed"))
    Z = ca.SX.sym("Z", model.n_motors)
    v = (q - before) / T
    arm = arm_residual(model, q, v, (v - speed) / T, ca.SX.zeros(model.n_motors))
    value = model.output(case.output)(q[: model.n_arm], model.parameter_values) - Z
    return ca.Function("residual", [q, before, speed, Z], [ca.vertcat(T * T * arm, value)], {"cse": True})


def fsolve_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time the published method: fsolve with finite differences at every step."""
    residual, n = plain_residual(case), 400 if case.name == "e12" else 100

    def run() -> None:
        q, v = case.start, np.zeros(len(case.start))
        for output in case.problem.desired[:n]:
            new, *_ = fsolve(
                lambda x, q=q, v=v, output=output: residual(x, q, v, output).full().ravel(),
                q + T * v,
                xtol=1e-12,
                full_output=True,
            )
            q, v = new, (new - q) / T

    yield row(case.name, "DAE step, order 1, SciPy fsolve with finite differences", 1e6 * seconds(run, 2) / n, "us")


def virtual_machine_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time CasADi alone: its Newton solver with exact Jacobian, mapped over the samples in its virtual machine."""
    residual, nq = plain_residual(case), case.robot.n_coordinates
    solver = ca.rootfinder("step", "fast_newton", residual, {"abstol": 1e-12})
    state, Z = ca.MX.sym("state", 2 * nq), ca.MX.sym("Z", case.robot.n_motors)
    q, v = state[:nq], state[nq:]
    new = solver(q + T * v, q, v, Z)
    step = ca.Function("step", [state, Z], [ca.vertcat(new, (new - q) / T)])
    n = 800 if case.name == "e12" else 100
    accumulated = step.mapaccum(n)
    start, outputs = np.concatenate([case.start, np.zeros(nq)]), case.problem.desired[:n].T
    last = accumulated(start, outputs).full()[:nq, -1]
    took = seconds(lambda: accumulated(start, outputs), 3)
    yield row(case.name, "DAE step, order 1, CasADi virtual machine (fast_newton, mapaccum)", 1e6 * took / n, "us")
    functions = StepFunctions.of(case.equations, 1, T)
    ours = CompiledStepper(case.equations, functions)
    tolerance = newton_tolerance(case.equations, functions.gamma, case.start)
    z = ours.advance(ours.layout.at_rest(case.start), case.problem.desired[:n], tolerance).z[-1]
    yield row(case.name, f"largest difference to CasADi after {n} steps", float(np.max(np.abs(z - last))), "rad")


def index_one_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time the index-1 form and measure its drift, at two tolerances."""
    for rtol in (1e-6, 1e-9):
        begin = time.perf_counter()
        solution = solve_index_one(case.problem, "LSODA", rtol, 1e-2 * rtol)
        took = time.perf_counter() - begin
        n = case.problem.n_samples
        drift = output_drift(case.robot, case.output, solution.arm_position, case.problem.desired)
        yield row(case.name, f"index-1 form per sample, LSODA, rtol {rtol:g}", 1e6 * took / n, "us")
        yield row(case.name, f"drift of the output over {n} samples, LSODA, rtol {rtol:g}", drift, "m or rad")


def row(case: str, what: str, value: float, unit: str, goal: float | None = None) -> dict[str, Any]:
    """Return one row of the results."""
    return {"case": case, "what": what, "value": float(f"{value:.4g}"), "unit": unit, "goal": goal}


def main() -> None:
    """Print all rows as one JSON list."""
    e12, six_axis = Case.e12(load_robot("e12"), "e12"), Case.six_axis()
    fine = subdivided_e12(PIECES)
    plan: list[tuple[Case, tuple[Callable[[Case], Iterator[dict[str, Any]]], ...]]] = [
        (e12, (stepper_rows, reference_rows, interpreted_rows, fsolve_rows, virtual_machine_rows, index_one_rows)),
        (six_axis, (stepper_rows, reference_rows, interpreted_rows, fsolve_rows, virtual_machine_rows)),
        (Case.e12(fine, "e12, 60 arm coordinates, tool"), (stepper_rows,)),
        (Case.e12(fine, "e12, 60 arm coordinates, gears", "joints"), (stepper_rows, reference_rows)),
    ]
    rows = [one for case, parts in plan for part in parts for one in part(case)]
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
