"""The index-1 form of the inverse dynamics by a library integrator: the oracle of the DAE feedforward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.integrate import solve_ivp

from flexros.compile.compiled_function import CompiledFunction, compile_function
from flexros.errors import InputError, RunError
from flexros.feedforward.time_stepping.dae_equations import build_equations
from flexros.feedforward.time_stepping.initial_values import consistent_initial_values

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.problem import FeedforwardProblem
    from flexros.robot import Robot
    from flexros.robot.symbolic.model import SymbolicModel

RANK_TOLERANCE = 1e-12
"""Smallest pivot, relative to the largest, with which the torque still follows from the third derivative."""


@dataclass(frozen=True, eq=False)
class IndexOneSolution:
    """Solution at the sampling instants.

    Attributes:
        arm_position: Arm coordinates q_a [rad or m], shape (n, N).
        motor_position: Motor coordinates q_m [rad or m], shape (n, M).
        torque: Motor torque u [Nm or N], shape (n, M).
        evaluations: Number of evaluations of the right-hand side.
    """

    arm_position: FloatArray
    motor_position: FloatArray
    torque: FloatArray
    evaluations: int


def solve_index_one(
    problem: FeedforwardProblem, method: str = "LSODA", rtol: float = 1e-8, atol: float = 1e-10
) -> IndexOneSolution:
    """Integrate equations 7a to 7d with u from equation 7h (Moberg 2007, Paper B, section 6).

    The output equation is replaced by its third derivative, so the output drifts from the desired one: any error
    in position, speed or acceleration stays and grows with time squared. Nothing is done about that here; see
    `output_drift` for how large it becomes.

    Args:
        problem: Robot, trajectory (in the controlled output) and settings.
        method: Integrator of `scipy.integrate.solve_ivp`: LSODA, Radau and BDF are stiff, DOP853 is not.
        rtol: Relative tolerance of the integrator.
        atol: Absolute tolerance [rad, rad/s, m, m/s].

    Returns:
        The solution.

    Raises:
        InputError: A gear is stiff or has no damper, so that the third derivative does not hold the torque.
        RunError: The integrator gave up.
    """
    robot, trajectory = problem.robot, problem.trajectory
    if trajectory.joints or trajectory.output != problem.output:
        raise InputError(
            f"the index-1 form needs a trajectory of output '{problem.output}' itself, but it is one of "
            f"'{trajectory.output}'; give the path in that output"
        )
    problem.require_square(problem.output)
    right_hand_side = _right_hand_side(robot.model, problem.output)
    equations = build_equations(robot.model, problem.output)
    start = consistent_initial_values(robot, equations, problem.desired[0], problem.rigid_start)
    state = np.concatenate([start, np.zeros_like(start)])
    _, _, pivot = right_hand_side(state, np.zeros(robot.n_motors))
    if not pivot[0] > RANK_TOLERANCE:
        raise InputError(
            f"the third derivative of output '{problem.output}' of robot {robot.name} does not determine the torque: "
            "the index-1 form needs a damper at every gear; use method dae"
        )

    def rate(t: float, x: FloatArray) -> FloatArray:
        return right_hand_side(x, trajectory.evaluate(np.array([t]), 3)[3, 0])[0]

    end = float(problem.time[-1])
    result = solve_ivp(rate, (0.0, end), state, method, t_eval=problem.time, rtol=rtol, atol=atol)
    if not result.success:
        raise RunError(f"the index-1 form of robot {robot.name} aborted at t = {result.t[-1]:g} s: {result.message}")
    jerk = trajectory.evaluate(problem.time, 3)[3]
    torque = [right_hand_side(x, z)[1] for x, z in zip(result.y.T.copy(), jerk, strict=True)]
    n, nq = robot.n_arm, robot.n_coordinates
    return IndexOneSolution(result.y[:n].T.copy(), result.y[n:nq].T.copy(), np.array(torque), int(result.nfev))


def output_drift(robot: Robot, output: str, arm_position: FloatArray, desired: FloatArray) -> float:
    """Largest violation of the output equation, max |Gamma(q_a) - Z|.

    Args:
        robot: The robot.
        output: Name of the controlled output.
        arm_position: Arm coordinates [rad or m], shape (n, N).
        desired: Desired output [m or rad], shape (n, n_out).

    Returns:
        The violation [m or rad].
    """
    values = np.array(robot.model.output(output)(arm_position.T, robot.model.parameter_values)).T
    return float(np.max(np.abs(values - desired)))


def _right_hand_side(model: SymbolicModel, output: str) -> CompiledFunction:
    """Compile (x, Z''') -> x', u and a measure of how well u is determined."""
    nq, p = model.n_coordinates, model.parameter_values
    if nq != model.n_arm + model.n_motors:
        raise InputError("the index-1 form needs a flexible gear at every motor; use method dae")
    x, u, jerk = ca.SX.sym("x", 2 * nq), ca.SX.sym("u", model.n_motors), ca.SX.sym("jerk", model.n_motors)
    q, v = x[:nq], x[nq:]
    rate = model.derivative(x, u, ca.SX.zeros(6), p)
    value = model.output(output)(q[: model.n_arm], p)
    speed = ca.jacobian(value, q) @ v
    acceleration = ca.jacobian(speed, x) @ rate
    third = ca.jacobian(acceleration, x) @ rate
    gain = ca.jacobian(third, u)
    torque = ca.solve(gain, jerk - ca.substitute(third, u, ca.SX.zeros(model.n_motors)))
    determined = ca.fabs(ca.det(gain)) / (ca.norm_fro(gain) + 1e-300) ** model.n_motors
    results = [ca.substitute(rate, u, torque), torque, determined]
    return compile_function(ca.Function("index_one", [x, jerk], [ca.densify(part) for part in results], {"cse": True}))
