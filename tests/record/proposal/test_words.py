"""Assumptions of a proposal in words."""

from __future__ import annotations

from flexros.record.proposal.joints import JointMatch
from flexros.record.proposal.words import about_left_out, about_signs


def test_an_opposite_axis_is_that_of_either_format() -> None:
    said = about_signs([JointMatch("motor_1", "hip", -1, "name"), JointMatch("motor_2", "knee", 1, "name")])
    assert said.taken == "hip with the opposite sign, all others as in the log"
    assert "URDF or MJCF" in said.ground


def test_columns_of_a_matrix_are_left_out_in_a_word() -> None:
    said = about_left_out({f"heat[{k}]": "no quantity" for k in range(7)} | {"i": "a current", "": "no quantity"})
    assert (
        said.taken == "left out: heat[0] to heat[6] (no quantity); i (a current); a column without a name (no quantity)"
    )
