"""Lead by which a servo that follows the rate of its command acts: torque = k (r + lead r' - q) - d q'."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot


def servo_leads(robot: Robot, values: Mapping[str, float]) -> FloatArray:
    """Return the lead of each servo: feedforward times damping over stiffness [s], shape (M,).

    Args:
        robot: Robot with servos.
        values: Values of its free parameters by name; others are nominal.
    """

    def gains(kind: str) -> FloatArray:
        names = [f"{motor}.{SERVO}{kind}" for motor in robot.joint_names]
        return np.array([values[name] if name in values else robot.parameters[name].value for name in names])

    return gains("feedforward") * gains("damping") / gains("stiffness")
