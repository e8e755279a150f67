"""An arm that MuJoCo simulates, with a bag of it as others record one."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.config.yaml_file import parse_yaml
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from flexros.robot.exchange.urdf_import import skeleton_from_urdf

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
URDF = EXAMPLES / "ur5e.urdf"


@pytest.fixture(scope="session")
def arm_in_mujoco() -> Any:
    pytest.importorskip("mujoco")
    spec = importlib.util.spec_from_file_location("arm_in_mujoco", EXAMPLES / "arm_in_mujoco.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["arm_in_mujoco"] = module
    spec.loader.exec_module(module)
    module.DURATION = 10.0
    return module


@pytest.fixture(scope="session")
def ur5e() -> Robot:
    return robot_from_data(parse_yaml(skeleton_from_urdf(URDF), str(URDF)), str(URDF))


@pytest.fixture(scope="session")
def measured(arm_in_mujoco: Any) -> tuple[np.ndarray, np.ndarray]:
    """Positions [rad] and torques [Nm] of the arm."""
    return arm_in_mujoco.tracked(URDF, arm_in_mujoco.motion(arm_in_mujoco.HOME, 4), 4)


@pytest.fixture(scope="session")
def ur5e_record(measured) -> Record:
    """Its record in the coordinates of the robot file."""
    sign = np.array([1, 1, 1, 1, -1, 1.0])
    return Record(
        name="log",
        sample_time=0.002,
        position=sign * measured[0],
        torque=sign * measured[1],
        valid=np.ones(len(measured[0]), bool),
        measured_torque=True,
    )


@pytest.fixture
def written(arm_in_mujoco: Any, measured: tuple[np.ndarray, np.ndarray], tmp_path: Path):
    """Write the bag with torques, or positions, in another unit."""

    def write(torque: Any = 1.0, position: float = 1.0, prefix: str = "") -> Path:
        names = [f"{prefix}{joint.name}" for joint in arm_in_mujoco.mujoco.MjSpec.from_file(str(URDF)).joints]
        folder = tmp_path / "bag"
        arm_in_mujoco.record(URDF, folder, names, position * measured[0], torque * measured[1], 4)
        return folder

    return write
