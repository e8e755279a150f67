"""Jumps of dry friction that are placed within a step, as predictions take it."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.loop.prediction import PredictionLoop
from flexros.effects import parse_effect, place_effects
from flexros.robot import Robot, load_robot
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from tests.ur5e import ur5e

T = 0.008
ROTORS, LEVELS = (1.4, 1.4, 1.1, 0.25, 0.25, 0.2), (8.0, 9.0, 6.0, 1.5, 1.5, 1.0)


class Predicted:
    """Predictions of a robot with effects under held torques.

    Args:
        robot: The robot.
        effects: Its effects.
        steps: Steps per sample.
        placed: Whether jumps of dry friction are placed within a step.
    """

    def __init__(self, robot: Robot, effects: list[str], steps: int, *, placed: bool) -> None:
        self.model = PlantModel(robot, place_effects(robot, [parse_effect(text, "test") for text in effects]).laws)
        functions = self.model.functions(feed_through(robot.n_motors), placed=placed)
        self.loop = PredictionLoop(functions, sample_time=T, substeps=steps)
        self.n_states = 2 * robot.n_coordinates

    def states(self, start: np.ndarray, u: np.ndarray) -> np.ndarray:
        """States after every sample, shape (n, 2 n_coordinates)."""
        gain, nothing = np.zeros((self.loop.sizes.state, u.shape[1])), np.zeros(len(u))
        values = self.model.nominal_values
        run = self.loop.run(self.model.start(start), values, gain, u, np.zeros_like(u), nothing, record_states=True)
        assert run.states is not None
        return run.states[:, : self.n_states, 0]


@pytest.mark.parametrize("force", [0.0, -60.0])
@pytest.mark.parametrize("speed", [0.002, -0.002])
def test_a_slide_that_stops_or_reverses_gets_its_exact_way_in_one_step(speed: float, force: float) -> None:
    robot = load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})
    level, push = 40.0, force * np.sign(speed)
    mass = 1 / float(robot.model.acceleration([0], [0], [1], np.zeros(6), [])[0])
    braking = (level - force) / mass
    stop = abs(speed) / braking
    assert stop < T
    back = 0.5 * (abs(force) - level) / mass * (T - stop) ** 2 if abs(force) > level else 0.0
    way = np.sign(speed) * (0.5 * abs(speed) * stop - back)
    effects = [f"coulomb_friction@motor_1:level={level}"]
    found = Predicted(robot, effects, 1, placed=True).states(np.array([0.0, speed]), np.full((2, 1), push))
    assert found[1, 0] == pytest.approx(way, rel=1e-9)


@pytest.mark.slow
def test_one_step_of_an_arm_is_as_good_as_four_in_which_jumps_are_not_placed() -> None:
    robot = ur5e().with_values({f"motor_{k + 1}.inertia": value for k, value in enumerate(ROTORS)})
    effects = [f"coulomb_friction@motor_{k + 1}:level={value}" for k, value in enumerate(LEVELS)]
    random = np.random.default_rng(3)
    exact = Predicted(robot, effects, 64, placed=False)
    ways = [Predicted(robot, effects, steps, placed=placed) for steps, placed in ((1, True), (1, False), (4, False))]
    errors = []
    for motor in 4 * list(range(6)):
        start = np.concatenate([random.uniform(-1, 1, 6), random.choice([-1, 1], 6) * random.uniform(0.4, 0.8, 6)])
        start[6 + motor] *= 0.1
        held = robot.holding_torque(np.concatenate([start[:6], np.zeros(6)]))
        held[motor] -= 2 * np.sign(start[6 + motor]) * LEVELS[motor]  # it reverses, and the others go on
        u = np.repeat(held[None], 13, axis=0)
        right = exact.states(start, u)
        errors.append([float(np.abs(way.states(start, u) - right)[:, :6].max()) for way in ways])
    of_one, unplaced, of_four = np.sqrt(np.mean(np.square(errors), axis=0))
    assert of_one < of_four
    assert of_one < 0.2 * unplaced
