"""Short runs of a robot with an effect, and panels that find their own axes, for effects_pictures.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from svg_picture import Curve, Panel

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

NOMINAL, CHANGED = "#888888", "#c8541b"


@dataclass(frozen=True)
class Run:
    """A run of a robot.

    Attributes:
        time: Instants [s], shape (n,).
        command: Commanded torque [Nm or N], shape (n, M).
        position: Coordinates [q_a, q_m], shape (n, nq).
        speed: Their rates, shape (n, nq).
        encoder: Measured motor positions, shape (n, M).
        tool: Tool position [m], shape (n, 3).
    """

    time: FloatArray
    command: FloatArray
    position: FloatArray
    speed: FloatArray
    encoder: FloatArray
    tool: FloatArray

    def acceleration(self, coordinate: int) -> FloatArray:
        """Return the mean acceleration from each sample to the next, the last one twice, shape (n,)."""
        steps = np.diff(self.speed[:, coordinate]) / (self.time[1] - self.time[0])
        return np.append(steps, steps[-1])


def with_effects(robot: Robot, *texts: str) -> RobotWithEffects:
    """Put effects onto a robot."""
    return place_effects(robot, [parse_effect(text, "picture").on(robot) for text in texts])


def run(
    robot: Robot,
    texts: Sequence[str],
    torque: Callable[[float], Sequence[float]],
    duration: float,
    start: Sequence[float] | None = None,
) -> Run:
    """Move a robot by a torque.

    Args:
        robot: The robot.
        texts: Effects, e.g. "backlash@motor_1:gap=1e-3".
        torque: Torque of the motors over time.
        duration: Length of the run [s].
        start: State [q, v] at the start; default: zero.
    """
    placed = with_effects(robot, *texts)
    state = np.zeros(2 * robot.n_coordinates) if start is None else np.array(start, dtype=float)
    first = np.array(torque(0.0), dtype=float)
    plant = Plant(placed.robot, robot.sample_time, state, laws=placed.laws, torque=first)
    rows: list[tuple[float, FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for k in range(round(duration / robot.sample_time)):
        command = np.array(torque(k * robot.sample_time), dtype=float)
        rows.append((k * robot.sample_time, command, plant.state, plant.measure(), plant.tool_pose()[:3]))
        plant.advance(command)
    time, commands, states, encoder, tool = (np.array(column) for column in zip(*rows))
    position, speed = np.split(states, 2, axis=1)
    return Run(time, commands, position, speed, encoder, tool)


def magnitude(robot: Robot, texts: Sequence[str], frequency: FloatArray, motor: int = 0) -> FloatArray:
    """Return the response from torque to acceleration of a motor, linearised at home [dB], shape (n,)."""
    placed = with_effects(robot, *texts)
    model = PlantModel(placed.robot, placed.laws)
    x, u = ca.SX.sym("x", model.n_states), ca.SX.sym("u", robot.n_motors)
    rate = model.derivative(x, u, np.zeros(6), ca.DM(0, 1))
    slopes = ca.Function("slopes", [x, u], [ca.jacobian(rate, x), ca.jacobian(rate, u)])
    A, B = (value.full() for value in slopes(model.start(placed.robot.equilibrium()), np.zeros(robot.n_motors)))
    row = robot.n_coordinates + robot.motor_rows[motor]
    responses = [
        A[row] @ np.linalg.solve(2j * np.pi * f * np.eye(len(A)) - A, B[:, motor]) + B[row, motor] for f in frequency
    ]
    return np.asarray(20 * np.log10(np.abs(responses)))


def ticks(values: Sequence[FloatArray]) -> tuple[float, ...]:
    """Choose four to seven round marks that enclose all values."""
    low, high = min(float(np.min(v)) for v in values), max(float(np.max(v)) for v in values)
    if high - low < 1e-12:
        low, high = low - 1.0, high + 1.0
    rough = (high - low) / 4
    power = 10 ** np.floor(np.log10(rough))
    step = next(m * power for m in (1, 2, 2.5, 5, 10) if m * power >= rough * 0.999)
    first, last = np.floor(low / step + 1e-6), np.ceil(high / step - 1e-6)
    return tuple(float(f"{step * k:.6g}") for k in np.arange(first, last + 1))


def panel(
    title: str,
    x_label: str,
    y_label: str,
    curves: Sequence[Curve],
    x_ticks: Sequence[float] | None = None,
    *,
    logarithmic: bool = False,
) -> Panel:
    """Return a panel whose axes enclose its curves."""
    across = ticks([curve.x for curve in curves]) if x_ticks is None else x_ticks
    upward = ticks([curve.y for curve in curves])
    if any(curve.label for curve in curves):  # room for the legend
        upward = (*upward, 2 * upward[-1] - upward[-2])
    return Panel(title, x_label, y_label, curves, across, upward, logarithmic)


def changed(x: FloatArray, y: FloatArray, label: str = "with the effect", width: float = 1.3) -> Curve:
    """Draw what the robot with the effect does."""
    return Curve(x, y, label, CHANGED, width)


def nominal(x: FloatArray, y: FloatArray, label: str = "nominal", width: float = 1.3) -> Curve:
    """Draw what the nominal robot does."""
    return Curve(x, y, label, NOMINAL, width)
