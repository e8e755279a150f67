from __future__ import annotations

import pytest

from flexros.robot import Robot, load_robot
from flexros.trajectory import Trajectory
from tests.feedforward.cases import BANG_BANG, CIRCLE, SMOOTH, tool_trajectory


@pytest.fixture(scope="session")
def e12() -> Robot:
    return load_robot("e12")


@pytest.fixture(scope="session")
def smooth(e12: Robot) -> Trajectory:
    return tool_trajectory(e12, CIRCLE, SMOOTH)


@pytest.fixture(scope="session")
def circle(e12: Robot) -> Trajectory:
    return tool_trajectory(e12, CIRCLE, BANG_BANG)
