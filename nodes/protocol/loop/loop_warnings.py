"""What a plant warns of on /diagnostics; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.protocol.loop.torque_use import SAMPLES_AT_LIMIT

if TYPE_CHECKING:
    from collections.abc import Mapping

LATE_PERCENT = 5.0
"""Share of late cycles beyond which a plant warns [%], chosen: what a recorder beside the loop may cost."""


def loop_warnings(figures: Mapping[str, float], before: Mapping[str, float], controllers: int) -> list[str]:
    """Tell what has not been as it should be since the last message.

    Args:
        figures: Figures of the plant; counts since the beginning, timing since the last message.
        before: Figures of the last message.
        controllers: How many nodes publish joint_commands.

    Returns:
        Half sentences, none when all is well.
    """

    def new(name: str) -> int:
        count, last = figures.get(name, 0), before.get(name, 0)
        return int(count - last if count >= last else count)  # the loop may have begun anew

    found = [f"{controllers} nodes publish joint_commands"] if controllers > 1 else []
    for name in figures:
        if name.endswith(SAMPLES_AT_LIMIT) and new(name):
            found.append(f"{name.removesuffix(SAMPLES_AT_LIMIT)} at its torque limit in {new(name)} samples")
    if missed := new("missed_commands"):
        found.append(f"{missed} commands came too late")
    if (late := figures.get("late_percent", 0.0)) > LATE_PERCENT:
        found.append(f"{late:.0f} % of the cycles began late")
    return found
