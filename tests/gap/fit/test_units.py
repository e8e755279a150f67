"""Units of fitted numbers, for what turns and what slides."""

from __future__ import annotations

import re

import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.fit.units import unit_of_parameter
from flexros.robot import load_robot


def unit(effect: str, location: str, name: str, robot: str) -> str:
    return unit_of_parameter(Candidate(effects()[effect], location, ()), name, load_robot(robot))


@pytest.mark.parametrize(
    ("effect", "location", "name", "robot", "expected"),
    [
        ("coulomb_friction", "motor_1", "level", "four_mass_linear", "Nm"),
        ("coulomb_friction", "motor_1", "level", "emps", "N"),
        ("viscous_friction", "motor_1", "coefficient", "elbow", "Nm s/rad"),
        ("viscous_friction", "motor_1", "coefficient", "emps", "N s/m"),
        ("viscous_friction", "motor_1", "asymmetry", "emps", "1"),
        ("backlash", "motor_1", "gap", "elbow", "rad"),
        ("stiffness_error", "body_1.rz", "relative", "four_mass_linear", "1"),
        ("delay", "all", "time", "elbow", "s"),
    ],
)
def test_unit_of_a_number(effect: str, location: str, name: str, robot: str, expected: str) -> None:
    assert unit(effect, location, name, robot) == expected


@pytest.mark.parametrize("effect", effects().values(), ids=effects())
def test_every_fitted_number_states_its_unit(effect: type) -> None:
    for name in effect.ranges:
        assert re.search(r"\[[^\]]+\]", effect.model_fields[name].description or ""), name
