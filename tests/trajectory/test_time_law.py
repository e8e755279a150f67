from __future__ import annotations

import math

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.limits import Limits
from flexros.trajectory.polynomial import ninth_degree, quintic
from flexros.trajectory.time_law import TimeLaw, concatenated, positive

LAWS = {
    "quintic": quintic(2.0, 0.8),
    "ninth degree": ninth_degree(2.0, 0.8),
    "bang-bang": bang_bang_snap(2.0, Limits(3.0, 10.0, 60.0, 900.0)),
    "held": ninth_degree(2.0, 0.8).held(0.2, 0.3),
    "mirrored": bang_bang_snap(2.0, Limits(3.0, 10.0, 60.0, 900.0)).mirrored(),
}


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_agree_with_differences_inside_the_pieces(name: str) -> None:
    law = LAWS[name]
    for left, right in zip(law.knots[:-1], law.knots[1:], strict=True):
        h = 1e-4 * (right - left)
        t = np.linspace(left + 2 * h, right - 2 * h, 20)
        exact = law.evaluate(t)
        for order in range(1, 5):
            difference = (law.evaluate(t + h)[order - 1] - law.evaluate(t - h)[order - 1]) / (2 * h)
            scale = np.max(np.abs(exact[order])) + np.max(np.abs(exact[order - 1])) / law.duration
            np.testing.assert_allclose(difference, exact[order], atol=1e-6 * scale)


@pytest.mark.parametrize("name", LAWS)
def test_bounded_derivatives_are_continuous_but_the_highest(name: str) -> None:
    law = LAWS[name]
    step = 1e-9 * law.duration
    for knot in law.knots:
        left, right = law.evaluate(np.array([knot - step, knot + step])).T
        for order in range(min(5, law.bounded_derivatives)):
            size = np.max(np.abs(law.evaluate(np.linspace(0.0, law.duration, 999))[order]))
            assert abs(right[order] - left[order]) <= 1e-5 * size


@pytest.mark.parametrize("name", LAWS)
def test_law_rests_before_and_after(name: str) -> None:
    law = LAWS[name]
    values = law.evaluate(np.array([-1.0, -1e-12, law.duration, law.duration + 5.0]))
    np.testing.assert_array_equal(values[0], [law.start, law.start, law.end, law.end])
    np.testing.assert_array_equal(values[1:], 0.0)


def test_holds_shift_the_motion() -> None:
    t = np.linspace(0.0, 0.8, 30)[:-1]
    np.testing.assert_allclose(LAWS["held"].evaluate(t + 0.2), LAWS["ninth degree"].evaluate(t), rtol=1e-9, atol=1e-9)
    assert LAWS["held"].duration == pytest.approx(1.3)
    np.testing.assert_array_equal(LAWS["held"].evaluate(np.array([0.1]))[:, 0], 0.0)


def test_mirrored_law_runs_backwards() -> None:
    law, back = LAWS["bang-bang"], LAWS["mirrored"]
    t = np.linspace(0.001, law.duration - 0.001, 50)
    signs = np.array([1, -1, 1, -1, 1])[:, None]
    np.testing.assert_allclose(back.evaluate(law.duration - t), signs * law.evaluate(t), atol=1e-9)


def test_concatenated_laws_follow_each_other() -> None:
    law = concatenated([LAWS["bang-bang"], LAWS["mirrored"]])
    assert (law.start, law.end) == (0.0, 0.0)
    assert law.evaluate(np.array([LAWS["bang-bang"].duration]))[0, 0] == 2.0


def test_laws_that_do_not_meet_are_refused() -> None:
    with pytest.raises(
        InputError, match="a time law begins at 0 where the previous one ends at 2, allowed is the same"
    ):
        concatenated([LAWS["bang-bang"], LAWS["quintic"]])


@pytest.mark.parametrize("time", [-0.1, math.nan, math.inf])
def test_impossible_holds_are_refused(time: float) -> None:
    with pytest.raises(
        InputError, match=r"the hold before the move is .* s, allowed is 0 or a finite time; correct it"
    ):
        LAWS["quintic"].held(before=time)
    with pytest.raises(InputError, match="the hold after the move"):
        LAWS["quintic"].held(after=time)


def test_constant_pieces_have_no_derivatives() -> None:
    rest = TimeLaw(np.array([0.0, 1.0]), np.zeros(1), np.array([[3.0]]), 3.0, 3.0, 5, "rest")
    np.testing.assert_array_equal(rest.evaluate(np.array([0.5]))[:, 0], [3.0, 0, 0, 0, 0])


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_positive_refuses(value: float) -> None:
    with pytest.raises(
        InputError, match=f"the duration is {value:g} s, allowed is a finite number above 0; correct the dur"
    ):
        positive(value, "duration", "s")
