"""Numbers of bodies among the numbers of the model that are wrong."""

from __future__ import annotations

import pytest

from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.gap.answer.budget import _of_body, _of_load, _together
from flexros.gap.diagnose import diagnose
from flexros.gap.schema import ModelNumber
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.robot import load_robot
from tests.gap.rigid_arm import arm, record_of_arm


def test_numbers_of_a_body_are_listed_where_they_differ_clearly_and_beyond_their_tolerance() -> None:
    """The mass of 3 kg is known to 5 % in the file; the centre is off by less, and inertias are in the patch alone."""
    difference = BodyDifference(mass=0.6, x=0.002, yy=0.02)
    (row,) = _of_body(difference, "body_2", arm(), {"body_2.mass": 0.05, "body_2.center_of_mass.x": 1e-3})
    assert (row.location, row.name, row.nominal, row.unit) == ("body_2", "body_2.mass", 3.0, "kg")
    assert (row.value, row.std) == pytest.approx((3.6, 0.18))
    assert not _of_body(difference, "body_2", arm(), {"body_2.mass": 0.2, "body_2.center_of_mass.x": 1e-3})


def test_a_coordinate_of_a_load_that_no_torque_depends_on_is_no_finding() -> None:
    """All joints of the elbow turn about y; a place along it had been as well known as the others, 0.0000 m."""
    rows = _of_load(ToolLoad(mass=1.0, x=0.05), load_robot("elbow"), {"body_2.mass": 0.01}, 44.0)
    assert [row.name for row in rows] == ["tool_load.mass", "tool_load.x", "tool_load.z"]


def test_a_number_that_an_effect_and_its_tolerance_change_is_listed_once() -> None:
    effect, moved = (
        ModelNumber(location="tool", name="body_1.mass", nominal=6.0, value=value, std=std, unit="kg")
        for value, std in ((3.0, 0.3), (4.0, 0.4))
    )
    (row,) = _together([effect, moved])
    assert (row.value, row.std) == pytest.approx((1.0, 0.5))


@pytest.mark.slow
def test_what_a_log_leaves_open_of_masses_is_a_doubt_about_each() -> None:
    """Torques show only some combinations of masses and centres, and the file says the rest."""
    file = arm().with_values({"body_1.center_of_mass.x": 0.3, "body_2.mass": 3.6})
    search = SearchSettings(effects=("coulomb_friction", "viscous_friction"))
    settings = DiagnosisSettings(where=None, next_experiment=None, sensitivity=None, search=search)
    record = record_of_arm(imported=True, seconds=10.0)
    diagnosis = diagnose(record, file, tolerance={"inertia": 0.01}, settings=settings).diagnosis
    found = [one for one in diagnosis.model_numbers if one.location.startswith("body_")]
    assert {one.name for one in found} >= {"body_1.center_of_mass.x", "body_2.mass"}
    for one in found:
        assert abs(one.value - arm().parameters[one.name].value) < 3 * one.std
