"""A law with an observer and a computed-torque law, each one class, run by simulation, batch and controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
import pytest
from pydantic import Field
from scipy.linalg import solve_discrete_are
from scipy.signal import cont2discrete

from flexros.control.base import AbstractControlLaw
from flexros.identify.design.decay import slowest_decay
from flexros.robot.linear.linearise import linear_model
from flexros.scenario.batch import batch, whole_record
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext

pytestmark = pytest.mark.slow


class ObserverFeedback(AbstractControlLaw):
    """State feedback from a Kalman filter, both designed on the linear model at the home pose, without gravity.

    With the filtered state x, a deviation from home, and the state x_r of a rigid motion along the reference:
        x = z + L (y - C z),  u = feedforward - K (x - x_r),  z_next = A x + B u
    """

    kind: ClassVar[str] = "observer_feedback"

    effort: float = Field(description="weight of the torque [1/Nm2]")

    def matrices(self, context: LoopContext) -> tuple[FloatArray, ...]:
        """Return A, B, C, feedback gain K and filter gain L of the sampled loop."""
        A, B, C, _ = linear_model(context.robot).matrices()
        C = C[: context.n_motors]
        A, B, *_ = cont2discrete((A, B, C, np.zeros((len(C), B.shape[1]))), context.sample_time)
        cost = solve_discrete_are(A, B, np.eye(len(A)), self.effort * np.eye(B.shape[1]))
        K = np.linalg.solve(self.effort * np.eye(B.shape[1]) + B.T @ cost @ B, B.T @ cost @ A)
        spread = solve_discrete_are(A.T, C.T, B @ B.T, np.diag(context.robot.encoder_noise**2))
        L = np.linalg.solve(C @ spread @ C.T + np.diag(context.robot.encoder_noise**2), C @ spread).T
        return A, B, C, K, L

    def state_size(self, context: LoopContext) -> int:
        return 2 * context.robot.n_coordinates

    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        return ()

    def gains(self, context: LoopContext) -> FloatArray:
        return np.zeros(0)

    def function(self, context: LoopContext) -> casadi.Function:
        A, B, C, K, L = self.matrices(context)
        references, n = context.references, context.robot.n_coordinates
        z, r = casadi.SX.sym("c", 2 * n), casadi.SX.sym("r", references.size)
        y, g = casadi.SX.sym("y", context.measurements.size), casadi.SX.sym("g", 0)
        position, velocity = references.part(r, "motor_position"), references.part(r, "motor_velocity")
        x = z + L @ (y - C @ z)
        target = casadi.vertcat(casadi.repmat(position, n, 1), casadi.repmat(velocity, n, 1))
        command = references.part(r, "feedforward_torque") - K @ (x - target)
        return casadi.Function(self.kind, [z, r, y, g], [command, A @ x + B @ command])


class ComputedTorque(AbstractControlLaw):
    """Inverse dynamics of the rigid arm and its motors, with a PD of unit inertia as the commanded acceleration.

    a = w^2 e + 2 w (e - e_before) / T,  u = M(y) a + c(y, dr/dt) + gravity(y)
    """

    kind: ClassVar[str] = "computed_torque"

    bandwidth: float = Field(description="bandwidth w of the loop [rad/s]")

    def state_size(self, context: LoopContext) -> int:
        return context.n_motors + 1

    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        return ("bandwidth",)

    def gains(self, context: LoopContext) -> FloatArray:
        return np.array([self.bandwidth])

    def function(self, context: LoopContext) -> casadi.Function:
        model, arm, references = context.robot.model, context.robot.arm_from_gears, context.references
        c, r = casadi.SX.sym("c", self.state_size(context)), casadi.SX.sym("r", references.size)
        y, g = casadi.SX.sym("y", context.measurements.size), casadi.SX.sym("g")
        error, speed = references.part(r, "motor_position") - y, references.part(r, "motor_velocity")
        rate = casadi.if_else(c[-1] > 0.5, (error - c[:-1]) / context.sample_time, 0.0 * error)
        a, p = g**2 * error + 2 * g * rate, model.parameter_values
        torque = model.arm_inverse_dynamics(arm(y), arm(speed), arm(a), p)[list(context.robot.gear_rows)]
        command = torque + model.motor_inertia(p) * a
        return casadi.Function(self.kind, [c, r, y, g], [command, casadi.vertcat(error, 1.0)])


def scenario(robot: str, controller: AbstractControlLaw, target: list[float]) -> Scenario:
    """Move of the joints without feedforward torque, noise and disturbances."""
    path = {"type": "joint_moves", "points_from_start": [target]}
    law = {"type": "bang_bang_snap", "speed": 1.2, "acceleration": 3, "jerk": 40, "snap": 1000}
    return Scenario.model_validate(
        {
            "robot": robot,
            "controller": controller,
            "trajectory": {"path": path, "time_law": law, "hold_after": 1.0},
            "feedforward": {"method": "flexible_joint", "output": "joints"},
            "feedforward_torque": False,
            "noise": False,
        }
    )


OBSERVER = scenario("two_mass", ObserverFeedback(effort=1e-9), [0.5])
COMPUTED = scenario("elbow", ComputedTorque(bandwidth=60.0), [0.5, 0.2])


@pytest.mark.parametrize("wanted", [OBSERVER, COMPUTED], ids=["observer", "computed_torque"])
def test_simulation_batch_and_controller_give_the_same_bits(wanted: Scenario) -> None:
    run = Experiment.prepare(wanted)
    log = closed_loop(run)
    record = batch(run, whole_record, seeds=[0])[0]
    controller, plant, n = run.controller(), run.plant_in_time(), 50
    commands = []
    for reference in run.reference_signal[:n]:
        commands.append(controller.step(plant.measure(), reference))
        plant.advance(commands[-1])
    assert log.joint_commands.effort is not None
    assert np.array_equal(log.joint_commands.effort, record.command)
    assert np.array_equal(log.joint_commands.effort[:n], commands)


def test_loop_with_an_observer_has_the_poles_of_feedback_and_filter() -> None:
    law, context = ObserverFeedback(effort=1e-9), Experiment.prepare(OBSERVER).loop_context
    A, B, C, K, L = law.matrices(context)
    poles = np.concatenate([np.linalg.eigvals(A - B @ K), np.linalg.eigvals(A - A @ L @ C)])
    decay = slowest_decay(linear_model(context.robot), law, context, 0.0)
    assert decay == pytest.approx(-np.log(np.max(np.abs(poles))) / context.sample_time, rel=1e-6)


def test_move_under_state_feedback_ends_at_its_target() -> None:
    log = closed_loop(Experiment.prepare(OBSERVER))
    assert log.joint_states.position is not None
    assert log.joint_states.position[-1] == pytest.approx([0.5], abs=1e-3)


def test_computed_torque_holds_gravity_without_integral_action() -> None:
    run = Experiment.prepare(COMPUTED)
    position = closed_loop(run).joint_states.position
    assert position is not None
    reference = run.loop_context.references.part(run.reference_signal, "motor_position")
    assert np.max(np.abs(position - reference)[-1]) < 1e-3
    sag = np.max(np.abs(position - reference))
    lower = closed_loop(Experiment.prepare(COMPUTED.with_values({"controller": ComputedTorque(bandwidth=30.0)})))
    assert lower.joint_states.position is not None
    assert np.max(np.abs(lower.joint_states.position - reference)) > sag
