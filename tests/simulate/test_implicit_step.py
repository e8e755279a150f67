"""Implicit steps of arms whose servos and friction are much faster than a sample."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import yaml

from flexros.compile.loop.prediction import PredictionLoop
from flexros.effects import parse_effect, place_effects
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel
from tests.gap.rigid_arm import ARM
from tests.ur5e import ur5e

T = 0.004
N = 200
FRICTION = ("coulomb_friction@motor_1:level=3", "viscous_friction@motor_2:coefficient=40")


@cache
def stiff_arm(rotor: float = 0.02, limit: float = 1e4) -> Robot:
    """Two joints that their servos hold with time constants of some ms and less."""
    servo = "servo: {stiffness: 4000, damping: 400}"
    text = ARM.replace("{inertia: 0}", f"{{inertia: 0, torque_limit: {limit}, {servo}}}")
    robot = robot_from_data(yaml.safe_load(text), "stiff.yaml").commanded_by("position")
    return robot.with_values({"motor_1.inertia": rotor, "motor_2.inertia": rotor})


def commands(n_motors: int = 2, sample_time: float = T) -> np.ndarray:
    time = np.arange(N) * sample_time
    return 0.3 * np.column_stack([np.sin((3 + k) * time + k) for k in range(n_motors)])


def run(
    robot: Robot, steps: int, *effects: str, implicit: bool, u: np.ndarray | None = None, sample_time: float = T
) -> np.ndarray:
    """Positions of the joints after every sample, from rest."""
    laws = place_effects(robot, [parse_effect(text, "test") for text in effects]).laws
    model = PlantModel(robot, laws)
    functions = model.functions(feed_through(robot.n_motors), implicit=implicit)
    loop = PredictionLoop(functions, sample_time=sample_time, substeps=steps)
    driving = commands(robot.n_motors, sample_time) if u is None else u
    nothing = np.zeros((N, robot.n_motors))
    start = model.start(robot.equilibrium(motor_position=driving[0] if u is None else nothing[0]), driving[0])
    gain = np.zeros((loop.sizes.state, robot.n_motors))
    states = loop.run(start, model.nominal_values, gain, driving, nothing, np.zeros(N), record_states=True).states
    assert states is not None
    return states[:, : robot.n_motors, 0]


@pytest.mark.parametrize("effects", [(), FRICTION[1:]])
def test_the_error_falls_at_least_with_the_square_of_the_step(effects: tuple[str, ...]) -> None:
    exact = run(stiff_arm(), 256, *effects, implicit=False)
    coarse, fine = (np.abs(run(stiff_arm(), steps, *effects, implicit=True) - exact).max() for steps in (4, 8))
    assert coarse < 2e-6
    assert coarse / fine > 3.5


def test_dry_friction_is_that_of_many_small_steps() -> None:
    exact = run(stiff_arm(), 256, *FRICTION, implicit=False)
    without = run(stiff_arm(), 256, *FRICTION[1:], implicit=False)
    coarse, fine = (np.abs(run(stiff_arm(), steps, *FRICTION, implicit=True) - exact).max() for steps in (5, 20))
    assert fine < 0.5 * coarse
    assert coarse < 0.1 * np.abs(without - exact).max()


def test_a_joint_without_rotor_needs_no_more_steps() -> None:
    """Its time constant is some microseconds, which no Runge-Kutta step of this number follows."""
    light = stiff_arm(1e-6).with_values({"body_2.mass": 0.01, "body_2.inertia.yy": 1e-6})
    found = run(light, 5, implicit=True)
    assert np.abs(run(light, 5, implicit=False) - found).max() > 1.0
    np.testing.assert_allclose(found, run(light, 40, implicit=True), atol=3e-5)


def test_a_servo_at_its_limit_accelerates_by_its_limit() -> None:
    limited = stiff_arm(2.0, limit=30.0)
    jump = np.repeat([[0.0, 0.0], [0.2, -0.2]], [10, N - 10], axis=0)
    exact = run(limited, 256, implicit=False, u=jump)
    errors = [np.abs(run(limited, steps, implicit=True, u=jump) - exact).max() for steps in (5, 20)]
    assert errors[0] < 0.02 * 0.2
    assert errors[1] < 0.3 * errors[0]


def test_a_servo_of_a_light_joint_is_not_at_its_limit_for_the_sake_of_a_stage() -> None:
    """Its torque begins below the limit and is gone after microseconds; the stages of a step go 3.4 times as far."""
    values = {"body_2.mass": 0.01, "body_2.inertia.yy": 1e-6}
    jump = np.repeat([[0.0, 0.0], [0.0, 0.09]], [10, N - 10], axis=0)
    limited, free = (stiff_arm(1e-6, limit=limit).with_values(values) for limit in (400.0, 1e4))
    found, expected = (run(robot, 5, implicit=True, u=jump) for robot in (limited, free))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_long_dynamics_give_what_short_steps_give() -> None:
    """A six-axis arm under torques, whose wrists are braked by friction."""
    wrist = {"inertia": 0.02, "viscous_friction": 50.0}
    robot = ur5e().with_values({f"motor_{k}.{name}": value for k in (4, 5, 6) for name, value in wrist.items()})
    torque = np.repeat(robot.holding_torque(robot.equilibrium(motor_position=np.zeros(6)))[None], N, axis=0)
    torque = torque + 5.0 * commands(6)
    exact = run(robot, 64, implicit=False, u=torque)
    np.testing.assert_allclose(run(robot, 4, implicit=True, u=torque), exact, atol=2e-5)


def test_springs_have_no_implicit_step() -> None:
    assert not load_robot("elbow").is_rigid
    assert stiff_arm().is_rigid


def test_two_steps_of_10_ms_follow_torques_that_are_held() -> None:
    """Viscous friction stops these wrists within 1 ms, and dry friction reverses; 0.1 mrad is a step of 16 bits."""
    wrist = {"inertia": 0.005, "viscous_friction": 5.0}
    heavy = {f"motor_{k}.inertia": 1.0 for k in (1, 2, 3)}
    robot = ur5e().with_values({f"motor_{k}.{name}": value for k in (4, 5, 6) for name, value in wrist.items()} | heavy)
    still = np.zeros((N, 6))
    torque = robot.holding_torque(robot.equilibrium(motor_position=still[0]))
    driving = torque + np.array([60, 60, 30, 3, 3, 3]) * commands(6, 0.02)
    levels = (4, 4, 3, 0.3, 0.3, 0.3)
    friction = [f"coulomb_friction@motor_{k}:level={level}" for k, level in enumerate(levels, 1)]

    def moved(steps: int) -> np.ndarray:
        return run(robot, steps, *friction, implicit=True, u=driving, sample_time=0.02)[:30]

    exact, found = moved(200), moved(2)
    assert np.ptp(exact, axis=0).min() > 0.02
    np.testing.assert_allclose(found, exact, atol=1e-4)
