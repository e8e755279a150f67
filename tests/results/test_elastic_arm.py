"""The simulator of elastic_arm.md: another derivation of the arm that the library has."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.simulate.plant import Plant
from tests.program import program


@pytest.fixture(scope="module")
def simulator() -> ModuleType:
    return program("docs/results/programs/simulated/elastic_arm_plant.py")


def test_it_moves_as_the_arm_of_the_library(simulator: ModuleType) -> None:
    """From a bent pose at speed, under constant torques: weight, coupling, springs, dampers, rotors and friction."""
    robot = load_robot("elbow")
    arm, motors, speeds = [0.3, -0.5], [0.301, -0.499], [0.4, -0.7]
    command = (-700.0, 200.0)
    plant = Plant(robot, 1e-3, np.array([*arm, *motors, *speeds, *speeds]), substeps=20)
    other, state = simulator.Plant(simulator.Numbers()), [*motors, *arm, *speeds, *speeds, 0.0, 0.0]
    way = []
    for _ in range(200):
        plant.advance(np.array(command))
        for _ in range(10):
            state = other.step(state, command)
        way.append(state[:2])
    ours = plant.state
    assert state[:4] == pytest.approx([*ours[2:4], *ours[:2]], abs=1e-6)
    assert np.ptp(way, axis=0).min() > 0.02


def test_bristles_hold_up_to_the_level_of_the_friction(simulator: ModuleType) -> None:
    numbers = simulator.Numbers(coulomb=[10.0, 5.0], bristles=[1e4, 1e4], by_load=[0.1, 0.0])
    plant = simulator.Plant(numbers)
    assert plant._friction(0, 0.5, 3e-3, 200.0) == pytest.approx((30.0, 0.0))  # slides at 10 + 0.1 * 200 Nm
    assert plant._friction(1, 0.5, 1e-4, 200.0) == pytest.approx((1.0, 0.4))  # bends as a spring before
