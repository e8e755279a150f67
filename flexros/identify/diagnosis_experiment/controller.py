"""The controller of a diagnosis experiment whose scenario names none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.patching.patched_robot import load_patched
from flexros.identify.design.default_controller import default_controller

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.control.pid import Pid


def designed_controller(robot: str, values: Mapping[str, float], sample_time: float | None) -> Pid:
    """Design a PID for the robot of a scenario.

    Args:
        robot: Name or file of the robot, or of a patch, whose base robot is taken for the design.
        values: Numbers of the robot that the scenario replaces.
        sample_time: Time between two samples [s]; None for the robot's.

    Returns:
        The controller, made for the home pose.

    Raises:
        InputError: Robot or values are not possible, or no PID holds the robot.
    """
    loaded = load_patched(robot).with_values(values, "model.values").base
    return default_controller(loaded, loaded.sample_time if sample_time is None else sample_time)
