"""From the log of a robot with a hidden effect to a feedforward that knows it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.gap.answer.patch import write_patch
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.held_out.closed_loop_gap import closed_loop_gap
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario
from tests.gap.diagnosis_logs import settings_of

HIDDEN = "coulomb_friction@motor_1:level=1.5"
ROBOT = "four_mass_linear"


def tool(wanted: Scenario) -> Any:
    log = closed_loop(Experiment.prepare(wanted))
    assert log.tool_pose is not None
    return log.tool_pose.position


@pytest.mark.slow
def test_the_patch_of_a_diagnosis_brings_the_tool_back_to_the_path_without_effect(tmp_path: Path) -> None:
    experiment = load_scenario("diagnosis").with_values(
        {
            "robot": ROBOT,
            "plant.effects": [HIDDEN],
            "diagnosis.length": 10.0,
            "diagnosis.parts": ["creep", "moves"],
            "diagnosis.poses": 1,
        }
    )
    model = load_model(ROBOT)
    log = closed_loop(Experiment.prepare(experiment))
    record = replace(checked_log(log, model.robot, name="hidden"), tool=None)
    result = diagnose(record, model, log=log, settings=settings_of("coulomb_friction", "viscous_friction"))
    assert result.diagnosis.causes[0].effect == "coulomb_friction"
    ahead, *in_loop = result.signals
    assert ahead.signal == "motor_1 position, 0.1 s ahead"
    assert result.holdout is not None
    assert result.holdout.begin > 0
    repaired = model.with_effects(result.patch)
    assert in_loop == list(closed_loop_gap(log, model, repaired, begin=result.holdout.begin))
    assert in_loop != list(closed_loop_gap(log, model, repaired))
    patch = tmp_path / "patch.yaml"
    write_patch(result, ROBOT, patch)

    plain = Scenario.model_validate(
        {
            "name": "moves",
            "robot": ROBOT,
            "noise": False,
            "trajectory": {
                "path": {"type": "joint_moves", "points_from_start": [[10.0]]},
                "time_law": {"type": "ninth_degree", "duration": 0.8},
            },
            "feedforward": {"method": "dae", "output": "joints"},
            "controller": {"kind": "pid", "kp": 22, "kd": 2.35, "derivative_filter": 2.6e-3},
        }
    )
    hidden = plain.with_values({"plant.effects": [HIDDEN]})
    ideal = tool(plain)
    before, after = (
        np.abs(tool(one) - ideal).max() for one in (hidden, hidden.with_values({"feedforward_model": str(patch)}))
    )
    assert before > 3e-4
    assert after < 0.05 * before
