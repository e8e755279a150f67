"""Tunable structures."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.design.fixed_structure import pid_system
from flexros.control.design.tunable import PID, TunableStructure
from flexros.control.pid import Pid
from flexros.control.state_space import StateSpace

T = 5e-4
FREQUENCY = np.array([0.1, 3.0, 50.0, 800.0])


@pytest.mark.parametrize(
    ("structure", "order"),
    [
        (TunableStructure(), 2),
        (TunableStructure(lead_lags=1), 3),
        (TunableStructure(sections=2), 6),
        (TunableStructure(sections=1, acceleration=True, acceleration_sections=1), 8),
    ],
)
def test_structure_starts_as_the_pid_and_has_its_order(structure: TunableStructure, order: int) -> None:
    system = structure.system(structure.start(), T)
    assert (system.order, structure.order) == (order, order)
    plain = pid_system(*PID.values(), T).response(FREQUENCY, T)[:, 0, 0]
    np.testing.assert_allclose(system.response(FREQUENCY, T)[:, 0, 0], plain, rtol=1e-9)


def test_point_of_the_search_comes_back_to_its_values() -> None:
    structure = TunableStructure(sections=1, acceleration=True)
    values = structure.start({"kp": 7.0}) | {"acceleration.gain": -3.0}
    assert structure.values(structure.vector(values)) == pytest.approx(values)
    assert structure.start(values)["kp"] == 7.0


def test_plain_structure_is_a_pid_law_and_richer_ones_are_matrices() -> None:
    assert isinstance(TunableStructure().law(PID, T), Pid)
    rich = TunableStructure(acceleration=True)
    law = rich.law(rich.start(), T)
    assert isinstance(law, StateSpace)
    assert law.inputs == ("motor_position_error", "tool_acceleration")


def test_acceleration_passes_between_its_corners() -> None:
    structure = TunableStructure(acceleration=True)
    values = structure.start() | {"acceleration.gain": 2.0}
    found = np.abs(structure.system(values, T).response(np.array([0.01, 5.0, 500.0]), T)[:, 0, 1])
    s = 2j * np.pi * 5.0
    assert found[1] == pytest.approx(abs(2.0 * s / (s + 1.0) / (3e-3 * s + 1.0)), rel=1e-3)
    assert found[0] < 0.2
    assert found[2] < 0.4
