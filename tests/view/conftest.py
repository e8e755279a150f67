"""A short run over which the viewer is tried."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from flexros.scenario.scenario import load_scenario
from flexros.scenario.transports import run_direct

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(scope="session")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the log of the circle test with flexible-joint feedforward."""
    folder = tmp_path_factory.mktemp("view") / "circle_fj"
    run_direct(load_scenario("circle_fj"), folder).require_complete("circle_fj")
    return folder
