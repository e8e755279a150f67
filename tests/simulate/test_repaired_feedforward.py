"""A feedforward that knows the hidden effect of the plant: the robot moves as the one without effect does."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.effects import parse_effect
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario

pytestmark = pytest.mark.slow

MOVES = {
    "name": "moves",
    "robot": "four_mass",
    "noise": False,
    "trajectory": {
        "path": {"type": "joint_moves", "points_from_start": [[10.0]]},
        "time_law": {"type": "ninth_degree", "duration": 0.8},
    },
    "feedforward": {"method": "dae", "output": "joints"},
    "controller": {"kind": "pid", "kp": 22, "kd": 2.35, "derivative_filter": 2.6e-3},
}


def patch_file(folder: Path, robot: str, *texts: str) -> str:
    placed = [parse_effect(text, "test") for text in texts]
    effects = [
        {
            "effect": one.effect.name,
            "location": one.location,
            "parameters": one.effect.model_dump(mode="json", exclude_defaults=True),
        }
        for one in placed
    ]
    path = folder / "patch.yaml"
    path.write_text(json.dumps({"robot": robot, "effects": effects}), encoding="utf-8")
    return str(path)


def scenario(name: str) -> Scenario:
    return load_scenario(name) if name != "moves" else Scenario.model_validate(MOVES)


@cache
def tool_path(name: str) -> Any:
    return _tool_path(scenario(name))


def _tool_path(wanted: Scenario) -> Any:
    log = closed_loop(Experiment.prepare(wanted))
    assert log.tool_pose is not None
    return log.tool_pose.position


def errors(name: str, folder: Path, *effects: str) -> tuple[float, float]:
    """Largest distance of the tool from the run without effects [m]: effects hidden, and known to the feedforward."""
    hidden = scenario(name).with_values({"plant.effects": list(effects)})
    known = hidden.with_values({"feedforward_model": patch_file(folder, hidden.robot, *effects)})
    return tuple(float(np.abs(_tool_path(one) - tool_path(name)).max()) for one in (hidden, known))  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("effect", "left"),
    [
        ("coulomb_friction@motor_1:level=200,asymmetry=0.5", 0.01),
        ("viscous_friction@motor_2:coefficient=500,asymmetry=0.3", 1e-3),
        ("friction_drift@motor_1:coulomb=100,viscous=100,time_constant=0.5", 0.01),
        ("presliding_friction@motor_1:level=200,stiffness=1e6", 0.03),
        ("torque_bias@motor_2:level=100", 1e-3),
        ("torque_ripple@motor_1:amplitude=0.1,order=6,proportional=true", 1e-3),
        ("torque_gain_error@motor_1:relative=0.1", 1e-3),
        ("actuator_lag@motor_1:time_constant=0.003", 1e-3),
        ("delay@motor_2:time=0.0013", 1e-3),
        ("hysteresis@motor_1:level=300,angle=0.001", 0.01),
        ("transmission_error@motor_1:amplitude=0.0005,order=20", 1e-3),
        ("backlash@motor_1:gap=0.0005", 0.5),
        ("encoder_eccentricity@motor_1:amplitude=0.0005,order=20,phase=0.8", 1e-3),
        ("kinematic_error@body_2:angle=0.003,length=0.001", 1e-3),
        ("payload_error@tool:relative=0.05", 1e-3),
        ("nonlinear_stiffness@body_1.ry:relative=0.5,knee=0.01", 0.01),
    ],
)
def test_known_effect_moves_the_tool_off_its_path_no_more(tmp_path: Path, effect: str, left: float) -> None:
    hidden, known = errors("smooth_dae2", tmp_path, effect)
    assert hidden > 1e-4
    assert known < left * hidden


@pytest.mark.parametrize(
    ("effect", "left"),
    [
        ("coulomb_friction@motor_1:level=1.5", 0.01),
        ("delay@motor_1:time=0.002", 0.02),
        ("backlash@motor_1:gap=0.02", 0.5),
    ],
)
def test_values_on_the_motor_side_of_a_nonlinear_gear(tmp_path: Path, effect: str, left: float) -> None:
    hidden, known = errors("moves", tmp_path, effect)
    assert hidden > 5e-5
    assert known < left * hidden


def test_laws_of_one_gear_act_on_what_the_others_made_of_it(tmp_path: Path) -> None:
    hidden, known = errors(
        "smooth_dae2",
        tmp_path,
        "hysteresis@motor_1:level=200,angle=0.001",
        "backlash@motor_1:gap=0.0002",
        "transmission_error@motor_1:amplitude=0.0005,order=20,phase=0.8",
    )
    assert hidden > 2e-3
    assert known < 0.2 * hidden


def test_effects_of_many_kinds_are_made_up_for_together(tmp_path: Path) -> None:
    hidden, known = errors(
        "smooth_dae2",
        tmp_path,
        "coulomb_friction@motor_1:level=100",
        "torque_gain_error@motor_1:relative=-0.05",
        "actuator_lag@motor_1:time_constant=0.002",
        "transmission_error@motor_1:amplitude=0.0003,order=10",
        "encoder_eccentricity@motor_1:amplitude=0.0003,order=7",
        "stiffness_error@body_3.ry:relative=-0.1",
    )
    assert hidden > 2e-3
    assert known < 0.02 * hidden
