from __future__ import annotations

import math

import numpy as np
import pytest

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.trajectory.arc import circle
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.specification import TrajectorySpecification
from flexros.trajectory.time_law import TimeLaw

CIRCLE = circle(np.array([2.0, -0.3]), 0.025)
MOVE = JointMove(np.zeros(2), np.array([1.0, 0.5]))


def law(path: object, joints: bool = False, **time_law: object) -> TimeLaw:
    data = {"path": {"type": "circle", "radius": 1.0}, "time_law": time_law}
    return validate(TrajectorySpecification, data, "scenario.yaml, key trajectory").time_law.law(path, joints)  # type: ignore[arg-type]


def test_limits_hold_along_the_path() -> None:
    made = law(CIRCLE, type="bang_bang_snap", speed=0.5, acceleration=15, jerk=900, snap=54000)
    assert made.duration == pytest.approx(0.38083, abs=5e-6)


def test_limits_may_hold_for_the_angle() -> None:
    made = law(CIRCLE, type="bang_bang_snap", speed=20, acceleration=600, jerk=3.6e4, snap=2.16e6, limits_of="angle")
    assert made.duration == pytest.approx(0.38083, abs=5e-6)


def test_a_line_has_no_angle() -> None:
    with pytest.raises(
        InputError, match="limits_of: angle on a path without an angle, allowed there is path; leave limits_of"
    ):
        law(Line(np.zeros(2), np.ones(2)), type="ninth_degree", speed=1.0, limits_of="angle")


def test_one_limit_holds_for_every_joint_and_a_list_for_each() -> None:
    assert law(MOVE, True, type="ninth_degree", speed=1.0).duration == pytest.approx(630 / 256)
    assert law(MOVE, True, type="ninth_degree", speed=[1.0, 0.1]).duration == pytest.approx(5 * 630 / 256)
    with pytest.raises(InputError, match="there are 3 speed limits for 2 joints"):
        law(MOVE, True, type="ninth_degree", speed=[1.0, 0.1, 1.0])


def test_list_of_limits_along_a_tool_path_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"the speed of the time law is the list \[1.0, 2.0\], allowed is one number along"
    ):
        law(CIRCLE, type="ninth_degree", speed=[1.0, 2.0])


@pytest.mark.parametrize("kind", ["quintic", "ninth_degree"])
def test_polynomials_take_a_duration(kind: str) -> None:
    assert law(CIRCLE, type=kind, duration=0.8).duration == 0.8
    assert law(CIRCLE, type=kind, duration=0.8).name == kind


def test_duration_that_breaks_a_limit_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"duration of the ninth_degree time law is 0.1 s, allowed are at least 0.77\d+ s for"
    ):
        law(CIRCLE, type="ninth_degree", duration=0.1, speed=0.5)


@pytest.mark.parametrize("value", [0.0, -1, math.nan, math.inf, "fast", True, [], [1.0, -1.0]])
def test_impossible_limits_name_key_and_source(value: object) -> None:
    with pytest.raises(
        InputError, match=r"scenario.yaml, key trajectory: .*jerk.* allowed is a finite number above 0 .*; corr"
    ):
        law(CIRCLE, type="bang_bang_snap", speed=1.0, acceleration=1.0, jerk=value, snap=1.0)


@pytest.mark.parametrize(
    ("time_law", "message"),
    [
        ({"type": "bang_bang_snap", "speed": 1.0}, "bang_bang_snap has no snap, allowed is a number above 0; add snap"),
        ({"type": "quintic"}, "neither duration nor limits, allowed is either; add duration in s"),
        ({"type": "quintic", "duration": 1, "snap": 3.0}, "no bounded snap .* choose ninth_degree or bang_bang_snap"),
        ({"type": "quintic", "duration": 0}, "duration' is 0, but input should be greater than 0; correct the value"),
        ({"type": "bang_bang_snap", "snap": 1.0, "duration": 1.0}, "unknown key 'time_law.*duration'"),
        ({"type": "trapezoid"}, "allowed|expected"),
    ],
)
def test_bad_keys_are_refused_with_their_source(time_law: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=rf"scenario.yaml, key trajectory: .*{message}"):
        law(CIRCLE, **time_law)
