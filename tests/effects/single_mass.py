"""A rigid slide without friction of its own: one mass, of which the law of an effect at its motor can be read."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.robot import Robot, load_robot
from flexros.simulate.plant import Plant

T = 1e-3
SLIDE = load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})
MASS = SLIDE.parameters["motor_1.inertia"].value + SLIDE.parameters["body_1.mass"].value


def plant(
    *texts: str,
    start: tuple[float, ...] = (0.0, 0.0),
    substeps: int = 1,
    sample_time: float = T,
    robot: Robot = SLIDE,
) -> Plant:
    """Place effects on the slide, at a position and speed."""
    placed = place_effects(robot, [parse_effect(text, "test") for text in texts])
    return Plant(placed.robot, sample_time, np.array(start), laws=placed.laws, substeps=substeps)


def states(moving: Plant, samples: int, force: Callable[[float], float] = lambda time: 0.0) -> FloatArray:
    """Return position and speed at the samples, shape (samples + 1, 2); the force is held through each."""
    rows = [moving.state]
    for _ in range(samples):
        moving.advance([force(moving.time)])
        rows.append(moving.state)
    return np.array(rows)
