"""The model sets."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.benchmark.models import PARAMETERS, ROBOT, set_values
from flexros.robot import load_robot


def test_sets_have_one_and_ten_models() -> None:
    robot = load_robot(ROBOT)
    assert [set_values(robot, name).shape for name in ("nominal", "M1", "M2")] == [(1, 13), (10, 13), (10, 13)]


@pytest.mark.parametrize(("name", "size"), [("M1", (0.15, 0.10, 0.30)), ("M2", (0.30, 0.20, 0.50))])
def test_first_model_of_a_set_has_its_signs(name: str, size: tuple[float, float, float]) -> None:
    robot = load_robot(ROBOT)
    stiffness, inertia, losses = size
    ratio = dict(zip(PARAMETERS, set_values(robot, name)[0] / set_values(robot, "nominal")[0]))
    assert ratio["body_1.rz.stiffness"] == pytest.approx(1 + stiffness)
    assert ratio["body_3.rz.stiffness"] == pytest.approx(1 - stiffness)
    assert ratio["body_2.inertia.zz"] == pytest.approx(1 + inertia)
    assert ratio["body_2.rz.damping"] == pytest.approx(1 - losses)
    assert ratio["motor_1.viscous_friction"] == pytest.approx(1 - losses)


def test_deviations_of_the_first_nine_models_have_no_bias_of_their_own() -> None:
    robot = load_robot(ROBOT)
    ratios = set_values(robot, "M1")[:9] / set_values(robot, "nominal")
    assert np.all(np.abs(np.mean(ratios - 1.0, axis=0)) < 0.11)
