"""Parsing of options that several commands share."""

from __future__ import annotations

import pytest

from flexros.cli.options import parse_tolerance
from flexros.errors import InputError


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stiffness", "--tolerance is 'stiffness', but must be KIND=SHARE,..., for instance stiffness=0.03"),
        ("stifness=0.1", "unknown kind 'stifness' in --tolerance: did you mean 'stiffness'?"),
        ("damping=0.1,damping=0.2", "--tolerance gives damping twice; remove one of them"),
        ("damping=much", "--tolerance gives damping as 'much', but a relative deviation such as 0.03 is asked"),
        ("damping=30", "--tolerance gives damping as 30, allowed are relative deviations from 0 to below 1"),
    ],
)
def test_tolerances_are_checked(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_tolerance(text)
    assert str(caught.value).startswith(message)


def test_no_tolerance_means_that_of_the_robot_file() -> None:
    assert parse_tolerance("") == {}
    assert parse_tolerance("stiffness=0.03, inertia=0") == {"stiffness": 0.03, "inertia": 0.0}
