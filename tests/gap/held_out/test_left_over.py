"""What a model leaves one sample ahead decides whether there is a gap."""

from __future__ import annotations

import pytest

from flexros.gap.held_out.left_over import LeftOver
from flexros.gap.report.terminal import gap_verdict, hidden_line, left_line


@pytest.mark.parametrize(
    ("level", "of_machine", "ahead", "most_ahead", "lacking", "gap"),
    [
        (1.03, None, 50.0, 2.0, (), False),
        (1.05, None, 1.0, 2.0, (), True),
        (1.9, 2.0, 1.9, 2.0, (), False),
        (1.9, 2.0, 3.3, 2.0, (), True),
        (1.9, 2.0, 18.3, 40.6, (), False),
        (2.1, 2.0, 1.0, 40.6, (), True),
        (1.0, 2.0, 1.0, 2.0, ("motor_1",), True),
    ],
)
def test_the_number_and_its_bound_decide(
    level: float, of_machine: float | None, ahead: float, most_ahead: float, lacking: tuple[str, ...], gap: bool
) -> None:
    left = LeftOver(level, 1.04, of_machine, ahead, most_ahead, lacking)
    assert left.significant is gap
    line = left_line(left)
    assert float(line.split(": ")[1].split(",")[0]) == level
    assert "up to 1.040 is noise" in line
    assert ("or up to 2 " in line) == (of_machine is not None)
    assert all(name in line for name in lacking)


def test_numbers_far_out_of_tolerance_excuse_nothing_beyond_it() -> None:
    """With an inertia 10 tolerances off, six large effects of an arm were no gap."""
    left = LeftOver(1.65, 1.19, 2.0, 108.0, 117.0, strained=("motor_1.inertia",))
    assert left.significant
    assert left_line(left).endswith("and no number of the model is far out of its tolerance, as motor_1.inertia is")
    assert not LeftOver(1.1, 1.19, 2.0, 108.0, 117.0, strained=("motor_1.inertia",)).significant


@pytest.mark.parametrize(("level", "words"), [(1.1, "no more than noise"), (1.65, "no more than 2 times noise")])
def test_the_verdict_says_what_a_real_machine_may_leave(level: float, words: str) -> None:
    assert words in gap_verdict(LeftOver(level, 1.19, 2.0, 1.0, 2.0), "the model")


def test_what_an_assumed_tolerance_hides_is_stated() -> None:
    line = hidden_line(LeftOver(1.0, 1.04, 2.0, 1.0, 2.0, assumed=0.05, if_known=260.5))
    assert "known within 5 % of their rms is assumed" in line
    assert "within 0.5 %" in line
    assert "a gap of 260.5" in line
    assert "a tolerance of torque of 0.005" in line
    assert not hidden_line(LeftOver(1.0, 1.04, 2.0, 1.0, 2.0))
