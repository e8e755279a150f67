"""Waterfalls of the budget, drawn and written."""

from __future__ import annotations

import pytest

from flexros.gap.report.waterfall import rows_of, shown, waterfall_figure, waterfall_lines
from flexros.gap.schema import Diagnosis, Step, Waterfall


def step(effect: str, share: float, location: str = "motor_1") -> Step:
    return Step(effect=effect, location=location, share=share)


FIRST = Waterfall(
    joint="motor_1",
    before=0.6,
    steps=(step("coulomb_friction", 0.45), step("torque_bias", -0.05), step("backlash", 0.004, "motor_2")),
    left=0.196,
)
SECOND = Waterfall(joint="motor_2", before=0.395, steps=(step("coulomb_friction", 0.2), step("delay", 0.195)), left=0.0)
THIRD = Waterfall(joint="motor_3", before=0.005, steps=(), left=0.005)


@pytest.fixture
def diagnosis() -> Diagnosis:
    return Diagnosis.model_construct(waterfall=(SECOND, THIRD, FIRST))


def test_rows_lead_from_the_gap_before_to_what_is_left() -> None:
    rows = rows_of(FIRST)
    assert [row.name for row in rows] == ["before", "Coulomb friction", "torque bias", "left"]
    assert [row.begin for row in rows] == pytest.approx([0.0, 0.6, 0.15, 0.0])
    assert [row.words for row in rows] == ["60 %", "\u221245 %", "+5 %", "20 %"]


def test_small_steps_are_written_together() -> None:
    small = tuple(step(name, 0.008, "motor_2") for name in ("delay", "backlash", "hysteresis"))
    rows = rows_of(Waterfall(joint="motor_1", before=0.5, steps=small, left=0.476))
    assert [row.name for row in rows] == ["before", "all others", "left"]
    assert rows[1].share == pytest.approx(-0.024)


def test_effects_that_act_against_each_other_are_one_row() -> None:
    """The gap of a joint had grown from 4 to 67 % before the last effect closed all of it."""
    steps = (step("delay", -0.19, "all"), step("tool_load", -0.46, "tool"), step("stiffness_error", 0.69, "motor_2"))
    (_, row, left) = rows_of(Waterfall(joint="motor_2", before=0.04, steps=steps, left=0.0))
    assert row.name == "stiffness error with 2 others"
    assert row.words == "\u22124 %"
    assert row.parts == ("delay at all motors +19 %", "tool load at the tool +46 %", "stiffness error \u221269 %")
    assert left.total


def test_two_effects_that_act_against_each_other_are_both_named() -> None:
    steps = (step("torque_bias", -0.1), step("backlash", 0.3), step("coulomb_friction", 0.2))
    rows = rows_of(Waterfall(joint="motor_1", before=0.4, steps=steps, left=0.0))
    assert [row.name for row in rows[1:-1]] == ["backlash with torque bias", "Coulomb friction"]


def test_an_effect_of_another_joint_has_its_location() -> None:
    assert [row.name for row in rows_of(SECOND)][1:3] == ["Coulomb friction at motor_1", "delay at motor_1"]


def test_joints_come_by_their_gap_and_those_without_are_left_out(diagnosis: Diagnosis) -> None:
    assert [one.joint for one in shown(diagnosis)] == ["motor_1", "motor_2"]


def test_bars_of_a_joint_follow_one_another(diagnosis: Diagnosis) -> None:
    figure = waterfall_figure(diagnosis)
    first = figure.data[0]
    assert first.type == "waterfall"
    assert list(first.x) == pytest.approx([0.6, -0.45, 0.05, 0.196])
    assert list(first.measure) == ["absolute", "relative", "relative", "absolute"]
    assert "<b>motor_2</b>, before" in figure.layout.yaxis.ticktext


def test_a_long_label_has_more_room() -> None:
    """A line of a label is half a row high."""
    steps = (step("torque_curve", 0.3, "motor_2"), step("torque_bias", 0.1))
    one = Waterfall(joint="motor_1", before=0.5, steps=steps, left=0.1)
    axis = waterfall_figure(Diagnosis.model_construct(waterfall=(one,))).layout.yaxis
    lines = [1 + label.count("<br>") for label in axis.ticktext]
    apart = [after - before for before, after in zip(axis.tickvals, axis.tickvals[1:], strict=False)]
    assert max(lines) == 3
    assert all(between >= (above + below) / 4 for between, above, below in zip(apart, lines, lines[1:], strict=False))
    assert min(apart) == 1


def test_lines_have_bars_to_scale(diagnosis: Diagnosis) -> None:
    lines = waterfall_lines(diagnosis)
    assert lines[0] == "motor_1"
    bars = {line.split("%")[0].split()[0]: line.count("█") for line in lines[1:5]}
    assert bars["Before"] == 32
    assert bars["Coulomb"] == 24
    assert lines[2].endswith(" " * 8 + "█" * 24)


def test_nothing_is_written_without_a_budget() -> None:
    assert waterfall_lines(Diagnosis.model_construct(waterfall=())) == ()
