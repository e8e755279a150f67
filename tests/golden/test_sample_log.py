"""The sample log in `bags` is what the scenario still gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

SAMPLE = Path(__file__).parents[2] / "bags" / "sample_circle_dae"


@pytest.fixture(scope="module")
def logs() -> tuple[Log, Log]:
    return read_log(SAMPLE), closed_loop(Experiment.prepare(load_scenario("circle_dae")))


@pytest.mark.parametrize(
    ("topic", "field", "tolerance"),
    [
        ("joint_states", "position", 1e-9),
        ("joint_commands", "effort", 0.2),  # of 45,000 Nm: backward differences amplify last bits, see decision 0003
        ("joint_reference", "position", 1e-9),
        ("tool_pose", "position", 1e-9),
        ("tool_reference", "position", 1e-9),
    ],
)
def test_sample_is_reproduced(logs: tuple[Log, Log], topic: str, field: str, tolerance: float) -> None:
    sample, now = (getattr(log, topic) for log in logs)
    np.testing.assert_array_equal(sample.stamp, now.stamp)
    np.testing.assert_allclose(getattr(sample, field), getattr(now, field), atol=tolerance, rtol=0)


def test_sample_was_recorded_whole(logs: tuple[Log, Log]) -> None:
    sample, _ = logs
    assert sample.warnings == ()
    assert sample.provenance["n_samples"] == len(sample.joint_states.stamp) == 762
