"""A robot with one body more: a mass on a spring at the tool, or a foundation that gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.settings import validate
from flexros.robot import Robot
from flexros.robot.specification import RobotSpecification

if TYPE_CHECKING:
    from collections.abc import Mapping


def with_mode(robot: Robot, location: str, parameters: Mapping[str, float]) -> Robot:
    """Add a ring on a spring and a damper that turns about the axis of its neighbour.

    At the tool it has `ratio` times the inertia of the last body, or as a point that moves in the plane of the axes
    `ratio` times its mass; at the base it has `ratio` times the inertia that the
    whole arm has there at home. Its own frequency with the neighbour held is `frequency`.

    Args:
        robot: The robot.
        location: "tool" or "base".
        parameters: `frequency` [Hz], `ratio` [1], `damping` ratio [1], and at the tool `point`, 1 for a point mass.

    Returns:
        The robot with the body behind its last one, or before its first one.
    """
    data = robot.spec.model_dump()
    joint = robot.joints[-1 if location == "tool" else 0]
    axis = joint.name[-1]
    if parameters.get("point"):
        size = parameters["ratio"] * robot.spec.bodies[-1].mass.value
        body: dict[str, Any] = {"mass": size}
        directions = [f"t{other}" for other in "xyz" if other != axis]
    else:
        size = parameters["ratio"] * reference_inertia(robot, location)
        ring = {2 * other: size if other == axis else 0.5 * size for other in "xyz"}
        body, directions = {"inertia": ring}, [f"r{axis}"]
    speed = 2 * np.pi * parameters["frequency"]
    held = {"spring": size * speed**2, "damper": 2 * parameters["damping"] * size * speed}
    body["directions"] = dict.fromkeys(directions, held)
    data["unknown_parameters"], data["inverse_kinematics"] = (), "numerical"
    home = [float(value) for value in robot.home]
    if location == "tool":
        data["bodies"], data["home"] = (*data["bodies"], body), (*home, *[0.0] * len(directions))
    else:
        _rename(data)
        data["bodies"], data["home"] = (body, *data["bodies"]), (0.0, *home)
    source = f"{robot.name} with a mode at the {location}"
    return Robot(validate(RobotSpecification, data, source), source)


def reference_inertia(robot: Robot, location: str) -> float:
    """Return the inertia that a ratio multiplies [kg m2]: of the last body, or of the arm at home about its base."""
    if location == "base":
        arm = np.asarray(robot.model.arm_inertia(robot.home, robot.model.parameter_values))
        return float(arm[0, 0])
    body = robot.spec.bodies[-1]
    axis = robot.joints[-1].name[-1]
    return float(getattr(body.inertia, axis * 2).value)


def _rename(data: dict[str, Any]) -> None:
    """Count the bodies from the second one, wherever an arm coordinate is named."""

    def later(name: str) -> str:
        body, _, axis = name.partition(".")
        return f"body_{int(body.removeprefix('body_')) + 1}.{axis}"

    for body in data["bodies"]:
        body["parent"] = ""
    for output in data["outputs"].values():
        output["coordinates"] = tuple(later(name) for name in output["coordinates"])
    linear = data["tool"]["linear"]
    if linear is not None:
        linear["weights"] = {later(name): weight for name, weight in linear["weights"].items()}
