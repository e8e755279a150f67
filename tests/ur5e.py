"""The UR5e of the guide, simulated by MuJoCo with what its URDF lacks."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.config.yaml_file import parse_yaml
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

EXAMPLES = Path(__file__).parents[1] / "docs" / "examples"
URDF = EXAMPLES / "ur5e.urdf"
SIGN = np.array([1, 1, 1, 1, -1, 1.0])
"""Joints in the coordinates of the robot file: wrist_2 counts the other way."""


@cache
def arm_in_mujoco() -> Any:
    """Load the example as a module, with a motion of 10 s; skips without MuJoCo."""
    pytest.importorskip("mujoco")
    spec = importlib.util.spec_from_file_location("arm_in_mujoco", EXAMPLES / "arm_in_mujoco.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["arm_in_mujoco"] = module
    spec.loader.exec_module(module)
    module.DURATION = 10.0
    return module


@cache
def ur5e() -> Robot:
    """Make the robot of the URDF."""
    return robot_from_data(parse_yaml(robot_from_urdf(URDF).text, str(URDF)), str(URDF))


@cache
def measured() -> tuple[FloatArray, FloatArray]:
    """Return positions [rad] and torques [Nm] as the URDF counts them, shape (n, 6) each."""
    module = arm_in_mujoco()
    positions, torques = module.tracked(URDF, module.motion(module.HOME, 4), 4)
    return positions, torques


@cache
def ur5e_record() -> Record:
    """Return its record in the coordinates of the robot file."""
    positions, torques = measured()
    return Record(
        name="log",
        sample_time=0.002,
        position=SIGN * positions,
        torque=SIGN * torques,
        valid=np.ones(len(positions), bool),
        measured_torque=True,
    )
