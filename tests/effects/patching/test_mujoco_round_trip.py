"""A patch written into an MJCF brings MuJoCo closer to measured logs, which are not in this repository."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.program import program

pytest.importorskip("mujoco", reason="MuJoCo is not installed")

REALDATA = os.environ.get("FLEXROS_REALDATA", "")
DATA = Path(REALDATA) / "dfki_double_pendulum"
pytestmark = pytest.mark.skipif(
    not REALDATA or not DATA.is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with dfki_double_pendulum/, the measured pendulum",
)


@pytest.fixture(scope="module")
def script() -> ModuleType:
    return program("docs/results/programs/simulated/mujoco_round_trip.py")


@pytest.mark.parametrize("log", ["C_143339", "C_143524", "C_143906"])
@pytest.mark.parametrize("window", [0.1, 0.5])
def test_published_friction_halves_the_error(script: ModuleType, log: str, window: float, tmp_path: Path) -> None:
    models = script.models_of(DATA / script.NOMINAL, {"published": DATA / script.PUBLISHED}, tmp_path)
    recorded = script.read(DATA / f"{log}.csv")
    before, after = (np.linalg.norm(script.errors(model, recorded, window)) for model in models.values())
    assert after < 0.6 * before
