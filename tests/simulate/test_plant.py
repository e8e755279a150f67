"""The simulated robot, sample by sample."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter

from flexros.errors import InputError, RunError
from flexros.robot import load_robot
from flexros.simulate.disturbance import Disturbance
from flexros.simulate.plant import Plant

pytestmark = pytest.mark.slow

E12 = load_robot("e12")
T = 5e-4


def plant(**settings: object) -> Plant:
    return Plant(E12, T, E12.equilibrium(), **settings)  # type: ignore[arg-type]


def test_robot_at_rest_stays_at_rest() -> None:
    resting = plant()
    for _ in range(100):
        resting.advance([0.0, 0.0])
    assert np.array_equal(resting.state, E12.equilibrium())
    assert resting.sample == 100
    assert resting.time == pytest.approx(0.05)


def test_measuring_twice_gives_the_same_and_changes_nothing() -> None:
    noisy = plant(noise=True, seed=2)
    first = noisy.measure(), noisy.tool_pose()
    assert np.array_equal(noisy.measure(), first[0])
    assert np.array_equal(noisy.tool_pose(), first[1])
    assert np.array_equal(noisy.state, E12.equilibrium())


def test_not_measuring_does_not_change_the_motion() -> None:
    watched, alone = plant(noise=True, seed=2), plant(noise=True, seed=2)
    for _ in range(50):
        watched.measure()
        watched.tool_pose()
        watched.advance([100.0, -50.0])
        alone.advance([100.0, -50.0])
    assert np.array_equal(watched.measure(), alone.measure())
    assert np.array_equal(watched.tool_pose(), alone.tool_pose())


def test_noise_is_that_of_the_robot_file() -> None:
    noisy = plant(noise=True, seed=3)
    encoder, tool = [], []
    for _ in range(3000):
        encoder.append(noisy.measure())
        tool.append(noisy.tool_pose()[:3])
        noisy.advance([0.0, 0.0])
    np.testing.assert_allclose(np.std(encoder, axis=0), 2e-6, rtol=0.06)
    np.testing.assert_allclose(np.std(tool, axis=0), 20e-6, rtol=0.06)


def test_without_noise_the_sensors_are_exact() -> None:
    exact = plant()
    assert np.array_equal(exact.measure(), E12.equilibrium()[3:5])
    np.testing.assert_allclose(exact.tool_pose(), E12.tool_pose(E12.home), atol=1e-14)


def test_first_motion_is_torque_over_inertia() -> None:
    pushed = plant()
    pushed.advance([1000.0, 0.0])
    # the motor alone moves at first, q = u T^2 / (2 J_m), up to the damper's pull of order T
    np.testing.assert_allclose(pushed.state[3], 1000.0 * T**2 / (2 * 100.0), rtol=1e-3)


def test_force_at_the_tool_pushes_it_its_way() -> None:
    push = TypeAdapter(Disturbance).validate_python({"kind": "step", "at": "tool.fx", "amplitude": -5000.0})
    pushed = plant(disturbances=(push,))
    before = pushed.tool_pose()
    for _ in range(20):
        pushed.advance([0.0, 0.0])
    moved = pushed.tool_pose() - before
    assert moved[0] < -1e-4


def test_torque_acts_until_the_first_command_arrives() -> None:
    robot = load_robot("four_mass_linear")
    waiting = Plant(robot, T, np.zeros(8), torque=np.array([1.0]))
    waiting.advance([0.0])
    after_one = waiting.state[3]
    assert after_one == pytest.approx(1.0 * T**2 / (2 * 5e-3), rel=0.02)
    waiting.advance([0.0])
    assert waiting.state[7] == pytest.approx(1.0 * T / 5e-3, rel=0.05)  # no torque since: the speed has stayed


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ([1.0], r"robot e12 at sample 3 \(t = 0\.0015 s\): the torque command has 1 values, needed are 2"),
        ([1.0, 2.0, 3.0], r"the torque command has 3 values, needed are 2"),
        (
            [1.0, np.nan],
            r"robot e12 at sample 3 \(t = 0\.0015 s\): the torque command of motor_2 is nan, needed",
        ),
        ([-np.inf, 0.0], r"the torque command of motor_1 is -inf"),
    ],
)
def test_wrong_command_is_refused_and_changes_nothing(command: list[float], message: str) -> None:
    running = plant()
    for _ in range(3):
        running.advance([100.0, 0.0])
    before = running.state
    with pytest.raises(RunError, match=message):
        running.advance(command)
    assert np.array_equal(running.state, before)
    assert running.sample == 3


def test_state_that_is_not_finite_breaks_the_run_with_sample_and_time() -> None:
    running = plant()
    running.advance([0.0, 0.0])
    with pytest.raises(RunError, match=r"robot e12: the simulated state is not finite at sample 2 \(t = 0\.0010 s\)"):
        running.advance([1e300, 1e300])


def test_unknown_location_of_a_disturbance_is_refused() -> None:
    wrong = TypeAdapter(Disturbance).validate_python({"kind": "step", "at": "motor_3", "amplitude": 1.0})
    with pytest.raises(InputError, match=r"unknown location 'motor_3' in disturbances\[0\]\.at"):
        plant(disturbances=(wrong,))
