"""Loops of small robots for tests of control laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi
import numpy as np

from flexros.control.context import LoopContext
from flexros.control.limited import LoopSignals
from flexros.control.lqg import Lqg
from flexros.control.observed import AbstractObservedLaw
from flexros.control.observers.base import Estimate
from flexros.control.torque_feedback import TorqueFeedback
from flexros.robot import load_robot
from flexros.robot.robot import Robot, robot_from_data

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw


def loop_context(n_motors: int, sample_time: float, limits: Sequence[float] | None = None) -> LoopContext:
    """Build the loop of a chain of stiff joints; torque limits [Nm] of shape (n_motors,), infinite for none."""
    bodies = []
    for limit in limits or [np.inf] * n_motors:
        motor = {"inertia": 1.0} | ({"torque_limit": limit} if np.isfinite(limit) else {})
        bodies.append(
            {"inertia": {"zz": 1.0}, "length": [1, 0, 0], "directions": {"rz": {"spring": "rigid", "motor": motor}}}
        )
    names = [f"body_{number + 1}.rz" for number in range(n_motors)]
    data = {"name": "chain", "bodies": bodies, "outputs": {"joints": {"coordinates": names}}, "controlled": "joints"}
    return LoopContext(robot_from_data(data, "test"), sample_time)


def loop_of(
    law: AbstractControlLaw, n_motors: int, sample_time: float, limits: Sequence[float] | None = None
) -> LoopContext:
    """Build the loop of a law: stiff joints, or flexible joints with all sensors if the law needs them."""
    robot = loop_context(n_motors, sample_time, limits).robot
    if isinstance(law, AbstractObservedLaw | TorqueFeedback | Lqg):
        data = robot.spec.model_dump()
        data["sensors"]["encoder_noise"]["value"] = 1e-5
        for body in data["bodies"]:
            body["directions"]["rz"] |= {"spring": 100.0}
        link, imu = {"position": {}, "torque": {}}, {"acceleration": {}, "turning_rate": {}}
        robot = robot_from_data({**data, "sensors": {**data["sensors"], "link": link, "tool_imu": imu}}, "test")
    context = law.context(robot, sample_time)
    law.check(context)
    return context


def undamped(name: str) -> Robot:
    """Return a built-in robot whose gears are undamped."""
    robot = load_robot(name)
    return robot.with_values({key: 0.0 for key in robot.parameters if key.endswith(".damping")})


def law_of_states(law: AbstractObservedLaw, context: LoopContext) -> casadi.Function:
    """Return the command of a law from (q, v, r), with all states known."""
    robot, m = context.robot, context.n_motors
    q, v = casadi.SX.sym("q", robot.n_coordinates), casadi.SX.sym("v", robot.n_coordinates)
    r, y = casadi.SX.sym("r", context.references.size), casadi.SX.sym("y", context.measurements.size)
    gears, motors = list(robot.gear_rows), list(robot.motor_rows)
    estimate = Estimate(q[motors], v[motors], q[gears], v[gears])
    values = law.gains(context)
    gains = {key: casadi.DM(values[m * place : m * (place + 1)]) for place, key in enumerate(law.gain_keys)}
    command = law.command(estimate, LoopSignals(context, r, y), gains)
    return casadi.Function("command", [q, v, r], [command])


def closed_loop_matrix(law: AbstractObservedLaw, context: LoopContext, position: Sequence[float]) -> FloatArray:
    """Return A of the continuous closed loop x' = A x about rest, with all states known, at a reference at rest."""
    robot, model = context.robot, context.robot.model
    n = robot.n_coordinates
    state = robot.equilibrium(position)
    reference = np.zeros(context.references.size)
    for name, rows in (("motor_position", robot.motor_rows), ("link_position", robot.gear_rows)):
        reference[context.references.rows(name)] = state[list(rows)]
    reference[context.references.rows("feedforward_torque")] = robot.holding_torque(state)
    x = casadi.SX.sym("x", 2 * n)
    u = law_of_states(law, context)(x[:n], x[n:], reference)
    rate = model.derivative(x, u, np.zeros(6), model.parameter_values)
    slope = casadi.Function("slope", [x], [casadi.jacobian(rate, x), rate])
    A, still = slope(state)
    assert np.abs(still.full()).max() < 1e-6
    return np.asarray(A.full())
