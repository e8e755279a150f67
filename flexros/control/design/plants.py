"""Linear models of a robot over its spring range and parameter sets, continuous and sampled with delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile.command_delay import split_delay
from flexros.robot.linear.held_input import held_input
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class LinearPlants:
    """Continuous linear models x' = A x + B u + E w, y = C x, z = F x of Q models.

    Attributes:
        labels: Name of each model, length Q.
        A: Shape (Q, n, n).
        B: From the motor torques [Nm or N], shape (Q, n, M).
        C: To the measurements: motor positions [rad or m], then those of further sensors, shape (Q, n_measured, n).
        E: From the wrench at the tool [N, Nm], shape (Q, n, 6).
        F: To the position of the tool [m], shape (Q, 3, n).
    """

    labels: tuple[str, ...]
    A: FloatArray
    B: FloatArray
    C: FloatArray
    E: FloatArray
    F: FloatArray

    def __len__(self) -> int:
        return len(self.labels)


@dataclass(frozen=True, eq=False)
class SampledPlants:
    """Sampled linear models x+ = A x + B u + G d, y = C x, z = F x; past commands are states.

    The command u of a sample acts after the delay; the disturbance d = [torque at the motors (M), wrench at the tool
    (6)] is held from its sample to the next.

    Attributes:
        labels: Name of each model, length Q.
        A: Shape (Q, n, n), with the states of the delay last, newest command first.
        B: From the commands, shape (Q, n, M).
        C: To the measurements, shape (Q, n_measured, n).
        G: From the disturbances, shape (Q, n, M + 6).
        F: To the position of the tool, shape (Q, 3, n).
        sample_time: Time between two samples [s].
    """

    labels: tuple[str, ...]
    A: FloatArray
    B: FloatArray
    C: FloatArray
    G: FloatArray
    F: FloatArray
    sample_time: float

    def __len__(self) -> int:
        return len(self.labels)

    def part(self, first: int, last: int) -> SampledPlants:
        """Return the models from one number to before another."""
        parts = {name: getattr(self, name)[first:last] for name in ("labels", "A", "B", "C", "G", "F")}
        return replace(self, **parts)

    def measured_late(self, ages: Sequence[int]) -> SampledPlants:
        """Return the models with older measurements, whose delay lines are further states.

        Args:
            ages: Age of each measurement when it is used [samples], length n_measured.
        """
        count, n, more = len(self), self.A.shape[-1], sum(ages)
        A = np.zeros((count, n + more, n + more))
        A[:, :n, :n] = self.A
        C = np.concatenate([self.C, np.zeros((count, self.C.shape[1], more))], axis=2)
        begin = n
        for channel, age in enumerate(ages):
            if age:
                A[:, begin, :n] = self.C[:, channel]
                A[:, begin + 1 : begin + age, begin : begin + age - 1] = np.eye(age - 1)
                C[:, channel, :n], C[:, channel, begin + age - 1] = 0.0, 1.0
                begin += age
        B, G = (np.concatenate([part, np.zeros((count, more, part.shape[2]))], axis=1) for part in (self.B, self.G))
        F = np.concatenate([self.F, np.zeros((count, 3, more))], axis=2)
        return replace(self, A=A, B=B, C=C, G=G, F=F)


def linear_plants(
    robot: Robot,
    *,
    names: Sequence[str] = (),
    values: FloatArray | None = None,
    pose: FloatArray | None = None,
    label: str = "",
    further: ca.Function | None = None,
) -> LinearPlants:
    """Linearise a robot in every segment of its piecewise linear springs, for every set of parameters.

    Args:
        robot: The robot.
        names: Parameters that differ between the models.
        values: Their values (SI), shape (n_sets, n_parameters); default: those of the robot, one set.
        pose: Arm coordinates [rad or m], shape (N,); default: home of the robot.
        label: Beginning of the names of the models.
        further: Values of sensors beside the encoders from (x, p), see `PlantModel.further`; the inputs that act are
            held at rest, so it must not depend on the motor torques.

    Returns:
        The models, sets outside, spring segments inside.
    """
    sets = np.array([[robot.parameters[name].value for name in names]]) if values is None else np.asarray(values)
    evaluate = _slopes(robot, tuple(names), further)
    wrench = np.zeros(6)
    labels, matrices = [], []
    arm = robot.home if pose is None else np.asarray(pose, dtype=float)
    for number, parameters in enumerate(sets):
        rest = robot.equilibrium(arm)
        torque = robot.holding_torque(rest)
        for text, deflection in _segments(robot):
            state = rest.copy()
            state[: robot.n_arm] += deflection
            result = evaluate(state, torque, wrench, parameters)
            matrices.append([np.asarray(part, dtype=float) for part in result])
            which = f" set {number + 1}" if len(sets) > 1 else ""
            labels.append(f"{label}{which}{text}".strip() or robot.name)
    A, B, C, E, F = (np.array(part) for part in zip(*matrices, strict=True))
    return LinearPlants(tuple(labels), A, B, C, E, F)


def sampled_plants(plants: LinearPlants, sample_time: float, delay: float) -> SampledPlants:
    """Sample linear models with held commands and disturbances; exact, also for a delay of a fraction of a sample.

    Args:
        plants: The continuous models.
        sample_time: Time between two samples [s].
        delay: Delay of the command at the plant input [s].
    """
    split = split_delay(delay, sample_time)
    count, n, motors = plants.B.shape
    past = split.line_length * motors
    both = np.concatenate([plants.B, plants.E], axis=2)
    step, held = held_input(plants.A, both, sample_time)
    A, B = np.zeros((count, n + past, n + past)), np.zeros((count, n + past, motors))
    A[:, :n, :n] = step
    carried = np.broadcast_to(np.eye(n), (count, n, n))
    for piece in reversed(split.pieces):  # the last part of the sample reaches its end first
        part, entry = held_input(plants.A, plants.B, piece.duration)
        entry = carried @ entry
        if piece.age == 0:
            B[:, :n] += entry
        else:
            first = n + (piece.age - 1) * motors
            A[:, :n, first : first + motors] += entry
        carried = carried @ part
    if past:
        B[:, n : n + motors] = np.eye(motors)
        A[:, n + motors :, n : n + past - motors] = np.eye(past - motors)
    outputs = [np.concatenate([part, np.zeros((count, part.shape[1], past))], axis=2) for part in (plants.C, plants.F)]
    G = np.concatenate([held, np.zeros((count, past, held.shape[2]))], axis=1)
    return SampledPlants(plants.labels, A, B, outputs[0], G, outputs[1], sample_time)


def _slopes(robot: Robot, names: tuple[str, ...], further: ca.Function | None) -> ca.Function:
    """Return A, B, C, E, F as a function of state, torque, wrench and parameters."""
    model = robot.symbolic(names) if names else robot.model
    x, u = ca.SX.sym("x", 2 * robot.n_coordinates), ca.SX.sym("u", robot.n_motors)
    w, p = ca.SX.sym("w", 6), ca.SX.sym("p", len(names))
    rate = model.derivative(x, u, w, p)
    position = model.tool_pose(x[: model.tool_pose.numel_in(0)], p)[:3]
    measured = model.encoder(x[: model.encoder.numel_in(0)])
    if further is not None:
        inputs = ca.SX.zeros(further.numel_in(0) - x.numel())
        measured = ca.vertcat(measured, further(ca.vertcat(x, inputs), p))
    parts = [
        ca.jacobian(rate, x),
        ca.jacobian(rate, u),
        ca.jacobian(measured, x),
        ca.jacobian(rate, w),
        ca.jacobian(position, x),
    ]
    return ca.Function("slopes", [x, u, w, p], [ca.densify(part) for part in parts])


def _segments(robot: Robot) -> list[tuple[str, FloatArray]]:
    """Return text and arm deflection [rad or m], shape (N,), inside every segment of piecewise linear springs."""
    ranges = []
    for row, joint in enumerate(robot.joints):
        spring = joint.direction.spring
        law = spring.piecewise_linear if isinstance(spring, Spring) else None
        if law is None:
            continue
        ends = (0.0, *law.knots, 2.0 * law.knots[-1])
        middles = [0.5 * (low + high) * np.eye(robot.n_arm)[row] for low, high in pairwise(ends)]
        unit = "Nm/rad" if joint.rotary else "N/m"
        ranges.append([(f" {joint.name} {slope:g} {unit}", at) for slope, at in zip(law.slopes, middles)])
    return [
        (",".join(text for text, _ in chosen), sum((at for _, at in chosen), start=np.zeros(robot.n_arm)))
        for chosen in product(*ranges)
    ]
