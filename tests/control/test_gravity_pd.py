"""PD with gravity compensation: no sag at rest, where a PD alone sags."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


def last_error(controller: dict[str, Any]) -> np.ndarray:
    changes = {"noise": False, "feedforward_torque": False, "controller": controller}
    run = Experiment.prepare(load_scenario("elbow_gravity_pd").with_values(changes))
    log = closed_loop(run)
    assert log.joint_states.position is not None
    return np.asarray(run.reference.motor_position[-1] - log.joint_states.position[-1])


GAINS = {"kp": [1e5, 3e4], "kd": [6e3, 1.5e3]}


@pytest.mark.parametrize("at", ["reference", "measured"])
def test_motors_come_to_rest_on_their_reference(at: str) -> None:
    assert (
        np.max(np.abs(last_error({"kind": "gravity_pd", **GAINS, "at": at}))) < 1e-7
    )  # the last of the swing dies out


def test_a_pd_alone_sags() -> None:
    assert np.max(np.abs(last_error({"kind": "pid", **GAINS}))) > 1e-3
