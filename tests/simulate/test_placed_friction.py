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


def predicted(
    robot: Robot, effects: list[str], start: np.ndarray, u: np.ndarray, steps: int, *, placed: bool
) -> np.ndarray:
    """States of the robot after every sample under held torques, shape (n, 2 n_coordinates)."""
    model = PlantModel(robot, place_effects(robot, [parse_effect(text, "test") for text in effects]).laws)
    functions = model.functions(feed_through(robot.n_motors), placed=placed)
    loop = PredictionLoop(functions, sample_time=T, substeps=steps)
    gain = np.zeros((loop.sizes.state, robot.n_motors))
    run = loop.run(
        model.start(start), model.nominal_values, gain, u, np.zeros_like(u), np.zeros(len(u)), record_states=True
    )
    assert run.states is not None
    return run.states[:, : 2 * robot.n_coordinates, 0]


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
    found = predicted(
        robot,
        [f"coulomb_friction@motor_1:level={level}"],
        np.array([0.0, speed]),
        np.full((2, 1), push),
        1,
        placed=True,
    )
    assert found[1, 0] == pytest.approx(way, rel=1e-9)


@pytest.mark.slow
def test_one_step_of_an_arm_is_as_good_as_four_in_which_jumps_are_not_placed() -> None:
    robot = ur5e().with_values({f"motor_{k + 1}.inertia": value for k, value in enumerate(ROTORS)})
    effects = [f"coulomb_friction@motor_{k + 1}:level={value}" for k, value in enumerate(LEVELS)]
    random = np.random.default_rng(3)
    errors: dict[tuple[int, bool], list[float]] = {(1, True): [], (1, False): [], (4, False): []}
    for motor in 4 * list(range(6)):
        start = np.concatenate([random.uniform(-1, 1, 6), random.choice([-1, 1], 6) * random.uniform(0.4, 0.8, 6)])
        start[6 + motor] *= 0.1
        held = robot.holding_torque(np.concatenate([start[:6], np.zeros(6)]))
        held[motor] -= 2 * np.sign(start[6 + motor]) * LEVELS[motor]  # it reverses, and the others go on
        u = np.repeat(held[None], 13, axis=0)
        exact = predicted(robot, effects, start, u, 64, placed=False)
        for (steps, placed), found in errors.items():
            found.append(float(np.abs(predicted(robot, effects, start, u, steps, placed=placed) - exact)[:, :6].max()))
    of_one, unplaced, of_four = (np.sqrt(np.mean(np.square(found))) for found in errors.values())
    assert of_one < of_four
    assert of_one < 0.2 * unplaced
