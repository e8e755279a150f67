"""The UR5e of the guide, and bags of it as others record them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.arrays import FloatArray
from flexros.record.record import Record
from flexros.robot import Robot
from tests import ur5e as example


@pytest.fixture(scope="session")
def ur5e() -> Robot:
    return example.ur5e()


@pytest.fixture(scope="session")
def measured() -> tuple[FloatArray, FloatArray]:
    return example.measured()


@pytest.fixture(scope="session")
def ur5e_record() -> Record:
    return example.ur5e_record().part(0, 3000)


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """Write the bag with torques, or positions, in another unit."""

    def write(torque: Any = 1.0, position: float = 1.0, prefix: str = "") -> Path:
        module, (positions, torques) = example.arm_in_mujoco(), example.measured()
        names = [f"{prefix}{joint.name}" for joint in module.mujoco.MjSpec.from_file(str(example.URDF)).joints]
        folder = tmp_path / "bag"
        module.record(example.URDF, folder, names, position * positions, torque * torques, 4)
        return folder

    return write
