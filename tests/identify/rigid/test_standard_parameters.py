"""Parameters in which the torque is linear."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.standard_parameters import inertia_at_joint, standard_parameters
from flexros.robot import load_robot

STEEL = {"xx": 1.0, "yy": 2.0, "zz": 2.5, "xy": 0.1, "xz": -0.2, "yz": 0.3}


def test_inertia_at_the_joint_of_a_point_mass() -> None:
    moved = inertia_at_joint(dict.fromkeys(STEEL, 0.0), 2.0, np.array([3.0, 0.0, 1.0]))
    assert moved == {"xx": 2.0, "yy": 20.0, "zz": 18.0, "xy": 0.0, "xz": -6.0, "yz": 0.0}


def test_inertia_comes_back_to_the_centre() -> None:
    center = np.array([0.3, -0.2, 0.5])
    at_joint = inertia_at_joint(STEEL, 7.0, center)
    assert inertia_at_joint(at_joint, 7.0, center, sign=-1.0) == pytest.approx(STEEL)


def test_nominal_values_follow_from_the_robot_file(elbow) -> None:
    nominal = {parameter.name: parameter.nominal for parameter in standard_parameters(elbow)}
    assert nominal["body_1.first_moment.z"] == pytest.approx(60 * 0.4)
    assert nominal["body_1.inertia_at_joint.yy"] == pytest.approx(4.0 + 60 * 0.4**2)
    assert nominal["motor_2.inertia"] == 25
    assert nominal["motor_1.viscous_friction"] == 60
    assert nominal["motor_1.coulomb_friction"] == 0


def test_units_of_a_drive_that_slides(emps) -> None:
    units = {parameter.name: parameter.unit for parameter in standard_parameters(emps, asymmetric=True)}
    assert units["motor_1.viscous_friction_backward"] == "N s/m"
    assert units["motor_1.coulomb_friction_forward"] == "N"
    assert "motor_1.torque_offset" not in units


def test_friction_of_bodies_counts_where_the_file_gives_it(elbow) -> None:
    assert not any("body_1.viscous" in parameter.name for parameter in standard_parameters(elbow))
    parameters = standard_parameters(load_robot("four_mass_linear"))
    assert [p.name for p in parameters][-3:] == [f"body_{k}.viscous_friction" for k in (1, 2, 3)]
