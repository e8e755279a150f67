"""Default controller of a diagnosis experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.patching.patched_robot import load_patched
from flexros.identify.design.default_controller import default_controller

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.control.pid import Pid


def designed_controller(robot: str, values: Mapping[str, float], sample_time: float | None) -> Pid:
    """Design a PID for the robot of a scenario, at its home pose.

    Args:
        robot: Name or file of the robot, or of a patch, whose base robot is used for the design.
        values: Parameter values that the scenario replaces.
        sample_time: Time between two samples [s]; None for the robot's.

    Raises:
        InputError: Robot or values are invalid, or no PID stabilises the robot.
    """
    loaded = load_patched(robot).with_values(values, "model.values").base
    return default_controller(loaded, loaded.sample_time if sample_time is None else sample_time)
