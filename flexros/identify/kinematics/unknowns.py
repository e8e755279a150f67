"""What a kinematic identification estimates, and what is known before: lengths, angles, zeros, compliances, frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.robot.robot import robot_of
from flexros.robot.specification import RobotSpecification

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.robot import Robot

FRAME = ("frame.x", "frame.y", "frame.z", "frame.rx", "frame.ry", "frame.rz")
"""Frame of the robot's base in that of the tracker: displacement [m] and rotation vector [rad]."""


@dataclass(frozen=True)
class KinematicPrior:
    """Standard deviations before the measurement; a zero leaves the kind out (all chosen).

    Attributes:
        length: Of each component of a length vector [m].
        angle: Of each zero: encoders and mounting [rad].
        compliance: Of the logarithm of each stiffness [1].
        frame_position: Of the base in the frame of the tracker [m].
        frame_angle: Of its orientation [rad].
    """

    length: float = 2e-3
    angle: float = 2e-3
    compliance: float = 0.3
    frame_position: float = 0.5
    frame_angle: float = 0.2


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Unknown numbers theta: deviations from the nominal robot.

    Attributes:
        robot: The nominal robot, with a zero of 0 stated for every direction.
        parameters: Names of its parameters that are unknown, shape (P,).
        logarithmic: Whether theta is the logarithm of the parameter over its nominal value, shape (P,).
        nominal: Nominal values of the parameters, shape (P,).
        deviation: Standard deviations of theta, then of `FRAME`, before the measurement, shape (P + 6,).
    """

    robot: Robot
    parameters: tuple[str, ...]
    logarithmic: BoolArray
    nominal: FloatArray
    deviation: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns."""
        return (*self.parameters, *FRAME)

    def values(self, theta: FloatArray) -> FloatArray:
        """Return the parameters for deviations theta, shape (P,)."""
        own = theta[: len(self.parameters)]
        return np.asarray(np.where(self.logarithmic, self.nominal * np.exp(own), self.nominal + own))


def unknowns(robot: Robot, prior: KinematicPrior | None = None) -> Unknowns:
    """List the unknowns of a robot.

    Unknown are the components of all lengths, the zeros of all directions, and the stiffness of all springs, as far as
    the prior has a deviation for them. What the poses cannot tell apart keeps its prior deviation.

    Args:
        robot: The nominal robot.
        prior: What is known before the measurement; default: `KinematicPrior`.
    """
    prior = prior or KinematicPrior()
    stated = with_zeros(robot)
    found: list[tuple[str, bool, float]] = []
    for name in stated.parameters:
        kind = name.split(".")[1] if name.startswith("body_") else ""
        if kind == "length" and prior.length > 0:
            found.append((name, False, prior.length))
        elif name.endswith(".zero") and prior.angle > 0:
            found.append((name, False, prior.angle))
        elif name.endswith(".stiffness") and prior.compliance > 0:
            found.append((name, True, prior.compliance))
    if not found:
        raise InputError(
            f"nothing of robot {robot.name} is unknown with deviations of {prior.length:g} m, {prior.angle:g} rad and "
            f"{prior.compliance:g}; give one above zero of something that the robot has"
        )
    names = tuple(name for name, *_ in found)
    frame = [prior.frame_position] * 3 + [prior.frame_angle] * 3
    return Unknowns(
        robot=stated,
        parameters=names,
        logarithmic=np.array([logarithmic for _, logarithmic, _ in found], dtype=bool),
        nominal=np.array([stated.parameters[name].value for name in names]),
        deviation=np.array([deviation for *_, deviation in found] + frame),
    )


def with_zeros(robot: Robot) -> Robot:
    """Return the robot with a zero stated for every direction that moves; 0 where its file has none."""
    data = {**robot.spec.model_dump(), "inverse_kinematics": "numerical"}  # closed forms need exact geometry
    for joint in robot.joints:
        if joint.mode is None:
            direction = data["bodies"][joint.body]["directions"][joint.name.split(".")[1]]
            if direction.get("zero") is None:
                direction["zero"] = {"value": 0.0}
    return robot_of(validate(RobotSpecification, data, robot.source), robot.source)
