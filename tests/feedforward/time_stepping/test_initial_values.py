from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward.time_stepping.dae_equations import build_equations
from flexros.feedforward.time_stepping.initial_values import consistent_initial_values
from flexros.robot import Robot, load_robot
from tests.feedforward.cases import edited_robot


def test_start_of_e12_is_undeflected(e12: Robot) -> None:
    z = consistent_initial_values(
        e12, build_equations(e12.model), e12.forward_kinematics(e12.home), np.array([0.01, 0.29, 0])
    )
    np.testing.assert_allclose(z, [0, 0.3, 0, 0, 0.3], atol=1e-13)


def test_tool_is_on_the_path_in_spite_of_gravity() -> None:
    heavy = edited_robot("e12", lambda data: data.update(gravity=[0, 0, -9.81]))
    target = heavy.forward_kinematics(heavy.home)
    z = consistent_initial_values(heavy, build_equations(heavy.model), target, heavy.home)
    np.testing.assert_allclose(heavy.forward_kinematics(z[:3]), target, atol=1e-14)
    rest = heavy.equilibrium(z[:3], motor_position=z[3:])
    np.testing.assert_allclose(rest[:5], z, atol=1e-10)
    assert np.max(np.abs(z[3:] - z[:2])) > 0.01


def test_stiff_gear_carries_its_load() -> None:
    def tilt(data: dict[str, object]) -> None:
        data["gravity"] = [-9.81, 0, 0]

    emps = edited_robot("emps", tilt)
    z = consistent_initial_values(emps, build_equations(emps.model), np.array([0.1]), np.zeros(1))
    assert z[0] == pytest.approx(0.1, abs=1e-14)
    assert z[1] == pytest.approx(float(emps.holding_torque(emps.equilibrium([0.1]))[0]), rel=1e-12)
    assert abs(z[1]) > 100.0


def test_no_equilibrium_is_reported() -> None:
    elbow = load_robot("elbow")
    with pytest.raises(
        InputError, match=r"robot elbow has no equilibrium with its output at the start of the path, \["
    ):
        consistent_initial_values(elbow, build_equations(elbow.model), np.array([50.0, 0.0]), elbow.home)
