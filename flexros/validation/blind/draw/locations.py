"""Possible locations of deviations on a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.blind.plant.laws import OUTSIDE_LAWS

if TYPE_CHECKING:
    from flexros.robot import Robot

_GEARS = ("backlash", "hysteresis", "transmission_error", "varying_stiffness", "load_dependent_friction")
_SPRINGS = ("nonlinear_stiffness", "stiffness_error", "damping_error")
_TOOL = ("payload_error", "tool_pushes", "rotating_imbalance")


def places_of(effect: str, robot: Robot) -> tuple[str, ...]:
    """List the possible locations of a deviation on a robot.

    Args:
        effect: Its name.
        robot: The robot.

    Returns:
        Names of motors, springs or bodies, or "tool", "base", "all"; none where it makes no sense on this robot.
    """
    if effect in _GEARS:
        motors = zip(robot.joint_names, robot.gear_rows, strict=True)
        return tuple(name for name, arm in motors if robot.joints[arm].motor_coordinate is not None)
    if effect in _SPRINGS:
        return tuple(robot.joints[index].name for index in robot.spring_rows)
    if effect in _TOOL:
        return ("tool",)
    if effect == "extra_mode":
        return ("tool", "base")
    if effect == "gravity_error":
        heavy = [k + 1 for k, body in enumerate(robot.spec.bodies) if body.mass.value > 0]
        return tuple(f"body_{k}" for k in heavy) if np.any(robot.spec.gravity.value) else ()
    if effect == "kinematic_error":
        # not the last body, which has its length in common with the offset of the tracker's target
        long = [k + 1 for k, body in enumerate(robot.spec.bodies[:-1]) if np.any(body.length.value)]
        return tuple(f"body_{k}" for k in long) if robot.spec.tool.linear is None else ()
    if effect == "delay" and robot.n_motors > 1:
        return ("all", *robot.joint_names)
    if effect == "lost_commands" and effect in OUTSIDE_LAWS:
        return ("all",)
    return robot.joint_names
