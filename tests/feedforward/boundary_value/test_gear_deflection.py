from __future__ import annotations

import numpy as np
import pytest

from flexros.feedforward.boundary_value.gear_deflection import gear_deflections
from flexros.robot import load_robot


def test_linear_gear_follows_its_differential_equation() -> None:
    """tau = k d + D d' with tau = sin(w t) after rest: the error of the difference formula is of second order."""
    robot = load_robot("e12")
    k, D, w = 1e5, 50.0, 30.0
    errors = []
    for step in (1e-3, 5e-4):
        time = np.arange(0.0, 0.5, step)
        torques = np.tile(np.sin(w * time) ** 3, (2, 1)).T
        found = gear_deflections(robot, step).along(torques, np.zeros(2))[:, 0]
        response = sum(
            c * np.exp(1j * n * w * time) / (k + 1j * n * w * D)
            for n, c in ((3, 1j / 8), (-3, -1j / 8), (1, -3j / 8), (-1, 3j / 8))
        )
        errors.append(np.abs(found - response.real)[len(time) // 2 :].max())
    assert errors[1] < 1e-5 / k
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_nonlinear_gear_at_rest_has_the_deflection_of_its_spring() -> None:
    robot = load_robot("four_mass")  # slopes 16.7, 37.525, ... Nm/rad from 0, 0.016 rad
    found = gear_deflections(robot, 5e-4).along(np.full((2000, 1), 0.016 * 16.7 + 0.01 * 37.525), np.zeros(1))
    assert found[-1, 0] == pytest.approx(0.026, abs=1e-9)
