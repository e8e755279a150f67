"""The experiment of figure 3.8 in simulation."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.friction.laws import LAWS, fit_law
from flexros.identify.friction.points import constant_speed_points
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow


def log(speed: float) -> Log:
    scenario = load_scenario("friction_two_mass").with_values({"trajectory.time_law.speed": speed})
    return closed_loop(Experiment.prepare(scenario))


@pytest.fixture(scope="module")
def logs() -> list[Log]:
    return [log(speed) for speed in (0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 1.6, 2.0)]


def test_stribeck_friction_of_the_plant_is_found(logs: list[Log]) -> None:
    points = constant_speed_points(logs, "motor_1")
    assert len(points.speed) == 16
    np.testing.assert_allclose(np.sort(np.abs(points.speed))[::2], [0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 1.6, 2.0], rtol=1e-6)
    true = 6.0 + 3.0 * np.exp(-((points.speed / 0.3) ** 2))
    np.testing.assert_allclose(np.abs(points.torque), true, atol=0.5)  # the fastest phases are short: transient left
    fit = fit_law(LAWS[1], points)
    assert fit.values[1] == pytest.approx(6.0, rel=0.1)
    assert fit.values[2] == pytest.approx(3.0, rel=0.2)


def test_unknown_joint_and_missing_phase_are_refused(logs: list[Log]) -> None:
    with pytest.raises(InputError, match="joint"):
        constant_speed_points(logs[:1], "motor_9")
    at_rest = closed_loop(Experiment.prepare(load_scenario("two_mass_step")))
    with pytest.raises(InputError, match="no phase of at least"):
        constant_speed_points([at_rest], "motor_1")


def test_torques_are_those_of_the_joint_in_whatever_order_the_commands_have() -> None:
    stamp, speed = stamps_ns(8000, 1e-3), np.repeat([1.0, -1.0], 4000)
    own, other = 5.0 * np.sign(speed), np.full(8000, 8.0)
    own[3000] = np.nan
    states = JointSeries(stamp, ("motor_1", "motor_2"), position=np.zeros((8000, 2)))
    reference = JointSeries(stamp, ("motor_1", "motor_2"), velocity=np.stack([speed, 0 * speed], axis=-1))
    commands = JointSeries(stamp, ("motor_2", "motor_1"), effort=np.stack([other, own], axis=-1))
    points = constant_speed_points([Log(states, commands, reference)], "motor_1")
    np.testing.assert_allclose(points.torque, 5.0 * np.sign(points.speed))
