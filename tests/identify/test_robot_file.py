"""Robot files with identified values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.robot_file import IdentifiedValue, identified_file
from flexros.robot import load_robot


def again(text: str, tmp_path: Path):
    file = tmp_path / "new.yaml"
    file.write_text(text)
    return load_robot(file)


def test_values_sources_and_tolerances_are_read_again(tmp_path: Path) -> None:
    robot = load_robot("elbow")
    values = {"body_1.ry.stiffness": IdentifiedValue(1.7e5, 0.02), "motor_2.inertia": IdentifiedValue(24.0, 0.01)}
    new = again(identified_file(robot, values, "a test"), tmp_path)
    for name, entry in values.items():
        parameter = new.parameters[name]
        assert (parameter.value, parameter.source, parameter.tolerance) == (entry.value, "a test", entry.relative)
    for name in set(robot.parameters) - set(values):
        assert new.parameters[name] == robot.parameters[name]


def test_vector_has_one_tolerance(tmp_path: Path) -> None:
    values = {
        "body_1.center_of_mass.x": IdentifiedValue(3e-9, 1e6),
        "body_1.center_of_mass.z": IdentifiedValue(0.4, 0.01),
    }
    new = again(identified_file(load_robot("elbow"), values, "a test"), tmp_path)
    expected = np.hypot(3e-3, 4e-3) / 0.4
    assert new.parameters["body_1.center_of_mass.z"].tolerance == pytest.approx(expected, rel=1e-3)


def test_nonlinear_spring_keeps_its_law(tmp_path: Path) -> None:
    robot = load_robot("four_mass")
    new = again(identified_file(robot, {"body_1.rz.stiffness": IdentifiedValue(1.1, 0.05)}, "a test"), tmp_path)
    before, after = (r.spec.bodies[0].directions["rz"].spring.piecewise_linear for r in (robot, new))
    np.testing.assert_allclose(after.slopes, 1.1 * np.array(before.slopes))
    assert after.tolerance == 0.05


def test_tolerance_of_a_value_of_which_nothing_is_known(tmp_path: Path) -> None:
    values = {"motor_1.viscous_friction": IdentifiedValue(1e-12, np.inf)}
    new = again(identified_file(load_robot("elbow"), values, "a test"), tmp_path)
    assert new.parameters["motor_1.viscous_friction"].tolerance == 10.0


def test_value_that_is_not_physical() -> None:
    with pytest.raises(InputError, match="must not be negative"):
        identified_file(load_robot("elbow"), {"motor_1.inertia": IdentifiedValue(-1.0, 0.1)}, "a test")
