"""What a plant warns of."""

from __future__ import annotations

import pytest

from flexros_nodes.protocol.loop.loop_warnings import LATE_PERCENT, loop_warnings


def test_a_loop_as_it_should_be_warns_of_nothing() -> None:
    figures = {"missed_commands": 0, "late_percent": LATE_PERCENT, "motor_1.samples_at_torque_limit": 0}
    assert loop_warnings(figures, {}, 1) == []


@pytest.mark.parametrize(
    ("figures", "before", "warning"),
    [
        ({"motor_2.samples_at_torque_limit": 12}, {}, "motor_2 at its torque limit in 12 samples"),
        (
            {"motor_2.samples_at_torque_limit": 12},
            {"motor_2.samples_at_torque_limit": 5},
            "motor_2 at its torque limit in 7 samples",
        ),
        ({"missed_commands": 9}, {"missed_commands": 6}, "3 commands came too late"),
        ({"missed_commands": 2}, {"missed_commands": 6}, "2 commands came too late"),  # the loop has begun anew
        ({"late_percent": 7.6}, {"late_percent": 7.6}, "8 % of the cycles began late"),
    ],
)
def test_what_is_new_since_the_last_message_is_warned_of(
    figures: dict[str, float], before: dict[str, float], warning: str
) -> None:
    assert loop_warnings(figures, before, 1) == [warning]


def test_what_was_told_is_not_told_again() -> None:
    figures = {"missed_commands": 9, "motor_1.samples_at_torque_limit": 4}
    assert loop_warnings(figures, figures, 1) == []


def test_all_warnings_are_told() -> None:
    assert loop_warnings({"missed_commands": 1, "late_percent": 50.0}, {}, 2) == [
        "2 nodes publish joint_commands",
        "1 commands came too late",
        "50 % of the cycles began late",
    ]
