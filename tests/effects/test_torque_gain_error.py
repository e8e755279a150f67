"""The motor gives another torque than commanded."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario
from tests.effects.single_mass import MASS, T, plant, states


@pytest.mark.parametrize("relative", [0.1, -0.3])
def test_torque_is_scaled(relative: float) -> None:
    path = states(plant(f"torque_gain_error@motor_1:relative={relative}"), 100, lambda time: 40.0)
    assert path[-1, 1] == pytest.approx((1 + relative) * 40.0 / MASS * 100 * T, rel=1e-12)


def test_run_under_gravity_starts_at_rest_with_the_scaled_command() -> None:
    effects = ["torque_gain_error@motor_1:relative=0.25", "actuator_lag@motor_2:time_constant=0.004"]
    settings = {"robot": "elbow", "duration": 0.1, "feedforward": {"method": "none"}, "plant": {"effects": effects}}
    controller = {"kind": "pid", "kp": 0}
    experiment = Experiment.prepare(Scenario.model_validate({**settings, "controller": controller}))
    needed = experiment.plant.holding_torque(experiment.start_state)
    np.testing.assert_allclose(experiment.start_torque, needed / [1.25, 1.0], rtol=1e-12)
    falling = closed_loop(experiment).joint_states.position  # the controller gives nothing, so it falls at once
    assert falling is not None
    still = experiment.plant_in_time()
    for _ in range(100):
        still.advance(experiment.start_torque)
    assert np.max(np.abs(still.state - experiment.start_state)) < 1e-9
    assert np.max(np.abs(falling[-1] - falling[0])) > 1e-2
