"""Warnings in the diagnostics of the plant."""

from __future__ import annotations

import pytest

from flexros_nodes.protocol.loop.loop_diagnostics import LATE_PERCENT, loop_warnings


def test_healthy_loop_has_no_warning() -> None:
    figures = {"missed_commands": 0, "late_percent": LATE_PERCENT, "motor_1.samples_at_torque_limit": 0}
    assert loop_warnings(figures, {}, 1) == []


@pytest.mark.parametrize(
    ("figures", "previous", "warning"),
    [
        ({"motor_2.samples_at_torque_limit": 12}, {}, "motor_2 at its torque limit in 12 samples"),
        (
            {"motor_2.samples_at_torque_limit": 12},
            {"motor_2.samples_at_torque_limit": 5},
            "motor_2 at its torque limit in 7 samples",
        ),
        ({"missed_commands": 9}, {"missed_commands": 6}, "3 commands came too late"),
        ({"missed_commands": 2}, {"missed_commands": 6}, "2 commands came too late"),  # the loop was reset
        ({"late_percent": 7.6}, {"late_percent": 7.6}, "8 % of the cycles began late"),
    ],
)
def test_increase_since_the_last_message_is_reported(
    figures: dict[str, float], previous: dict[str, float], warning: str
) -> None:
    assert loop_warnings(figures, previous, 1) == [warning]


def test_unchanged_count_is_not_reported_again() -> None:
    figures = {"missed_commands": 9, "motor_1.samples_at_torque_limit": 4}
    assert loop_warnings(figures, figures, 1) == []


def test_all_warnings_are_reported() -> None:
    assert loop_warnings({"missed_commands": 1, "late_percent": 50.0}, {}, 2) == [
        "2 nodes publish joint_commands",
        "1 commands came too late",
        "50 % of the cycles began late",
    ]
