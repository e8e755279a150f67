"""Assumptions of a proposal in words."""

from __future__ import annotations

from flexros.record.proposal.joints import JointMatch
from flexros.record.proposal.words import about_signs


def test_an_opposite_axis_is_that_of_either_format() -> None:
    said = about_signs([JointMatch("motor_1", "hip", -1, "name"), JointMatch("motor_2", "knee", 1, "name")])
    assert said.taken == "hip with the opposite sign, all others as in the log"
    assert "URDF or MJCF" in said.ground
