"""Every built-in scenario runs in this process, stays stable and does what its description says."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario, scenario_names

pytestmark = pytest.mark.slow

LARGEST_ERROR = {
    "circle_dae": 3e-3,
    "circle_dae2": 1e-4,
    "circle_fj": 3e-3,
    "circle_flexible_links": 2e-6,
    "circle_pd": 0.053,
    "circle_stable_inversion": 3e-7,
    "diagnosis": 0.15,
    "elbow_accelerometer": 7e-5,
    "elbow_computed_torque": 5.7e-4,
    "elbow_extended_kalman": 3.2e-5,
    "elbow_feedback_linearisation": 6.3e-4,
    "elbow_gravity_pd": 0.017,
    "elbow_kalman": 2.9e-5,
    "elbow_moves": 5e-5,
    "elbow_quasi_static": 9.8e-5,
    "elbow_state_feedback": 3.2e-5,
    "elbow_time_optimal": 1.55e-4,
    "elbow_torque_feedback": 3.3e-5,
    "feedback_benchmark": 0.38,
    "four_mass_lqg": 0.147,
    "four_mass_state_space": 0.267,
    "friction_two_mass": 3e-3,
    "hidden_effect": 1.5e-3,
    "identify_e12": 0.0037,
    "identify_six_axis": 0.0143,
    "identify_six_axis_friction": 0.0126,
    "identify_two_mass": 0.0093,
    "regulator_four_mass": 0.3,
    "six_axis_moves": 3e-5,
    "smooth_dae": 3e-4,
    "smooth_dae2": 1e-5,
    "two_mass_step": 0.02,
}
"""Largest deviation of a motor from its reference [rad], 1.2 times what was found; a new scenario needs an entry."""

SHORTER: dict[str, dict[str, object]] = {"identify_six_axis": {"identification.blocks": 1}}
"""Of repeated blocks one is enough here."""


@lru_cache(maxsize=1)
def run(name: str) -> tuple[Experiment, Log]:
    experiment = Experiment.prepare(load_scenario(name).with_values(SHORTER.get(name, {})))
    return experiment, closed_loop(experiment)


@pytest.mark.parametrize("name", scenario_names())
def test_scenario_runs_to_its_end_within_its_limits(name: str) -> None:
    experiment, log = run(name)
    assert log.joint_commands is not None
    assert log.joint_reference is not None
    position, torque = log.joint_states.position, log.joint_commands.effort
    assert position is not None
    assert torque is not None
    assert len(position) == experiment.n_samples
    assert np.all(np.isfinite(position))
    assert np.all(np.abs(torque) < experiment.plant.torque_limits)  # no scenario lives on saturation
    assert np.max(np.abs(position - log.joint_reference.position)) < LARGEST_ERROR[name]  # type: ignore[operator]


def test_regulator_needs_little_torque_at_rest() -> None:
    _, log = run("regulator_four_mass")
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    assert np.ptp(log.joint_commands.effort[:1900]) < 5.0  # "torque noise" of Moberg (2007), Paper C, section 5.6


@pytest.mark.parametrize(
    "change",
    [
        {"controller.kp": 2.5 * 22, "controller.ki": 2.5 * 230, "controller.kd": 2.5 * 2.35},
        {"plant.values.delay": 2e-3},
        {"robot": "four_mass_linear"},
    ],
    ids=["gain times 2.5", "delay 2 ms", "linear gear"],
)
def test_regulator_is_as_robust_as_the_benchmark_demands(change: dict[str, object]) -> None:
    log = closed_loop(Experiment.prepare(load_scenario("regulator_four_mass").with_values(change)))
    assert log.tool_pose is not None
    assert np.max(np.abs(log.tool_pose.position[-500:, 0])) < 1.5e-4  # back at rest within the noise of the tracker


@pytest.mark.parametrize("name", ["elbow_moves", "six_axis_moves"])
def test_robot_under_gravity_starts_with_about_the_torque_that_holds_it(name: str) -> None:
    experiment = Experiment.prepare(load_scenario(name).with_values({"noise": False, "duration": 0.1}))
    log = closed_loop(experiment)
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    assert np.max(np.abs(experiment.start_torque)) > 100.0
    np.testing.assert_allclose(log.joint_commands.effort[0], experiment.start_torque, rtol=0.02, atol=0.1)
