"""Noise floors of a robot: sizes of effects at the limit of detection by its encoders.

The floor of a motor angle, and of a deflection of its gear, is the noise of its encoder. That of a speed is the noise
divided by 0.1 s. That of a torque is the constant torque that moves the motor by the noise within 0.1 s,
2 J noise / t^2, with the rigid inertia J at home while the other motors are held. Other quantities have no floor.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects.kinds.ranges import Range
    from flexros.robot import Robot

TIME = 0.1
"""Time in which a floor is reached [s] (chosen)."""
WORD = "floors"
"""Suffix of a value in floors: level=12floors."""
QUANTITIES = ("torque", "speed", "angle", "deflection")
"""Scales of ranges that have a floor."""


def check_has_floor(allowed: Range | None, parameter: str, source: str) -> None:
    """Refuse a value in floors of a parameter without floor.

    Args:
        allowed: Range of the parameter, None where it has none.
        parameter: Its name.
        source: Origin of the value; prefix of the error message.

    Raises:
        InputError: Names the parameter and the quantities that have a floor.
    """
    if allowed is None or allowed.scale not in QUANTITIES:
        raise InputError(
            f"{source}: parameter '{parameter}' is given in noise floors, but only torques, speeds, motor angles and "
            "deflections of gears have one; give it as a number"
        )


def floor_of(robot: Robot, allowed: Range, location: str, source: str) -> float:
    """Compute the noise floor of a parameter.

    Args:
        robot: The robot without effects.
        allowed: Range of the parameter, of a quantity that has a floor.
        location: Location of the effect: a motor or the spring of its gear.
        source: Name of the parameter; prefix of error messages.

    Returns:
        The floor [unit of the parameter].

    Raises:
        InputError: There is no motor at the location, or its encoder has no noise.
    """
    motor = next((motor for motor in robot.motors if location in (motor.name, motor.joint.name)), None)
    if motor is None:
        raise InputError(
            f"{source} is given in noise floors, but {location} has no motor with an encoder; give it as a number"
        )
    noise = float(robot.encoder_noise[motor.index])
    if noise <= 0:
        raise InputError(
            f"{source} is given in noise floors, but the encoder of {motor.name} of robot {robot.name} has no "
            "noise; give it as a number"
        )
    if allowed.scale == "torque":
        return 2 * float(rigid_inertia(robot)[motor.index]) * noise / TIME**2
    return noise / TIME if allowed.scale == "speed" else noise


def rigid_inertia(robot: Robot) -> FloatArray:
    """Compute the inertia at each motor at home, springs rigid, other motors held [kg m2 or kg], shape (M,)."""
    arm = np.diag(np.array(robot.model.arm_inertia(robot.home, robot.model.parameter_values)))
    motors = [robot.parameters[f"{name}.inertia"].value for name in robot.joint_names]
    inertia: FloatArray = arm[list(robot.gear_rows)] + np.array(motors)
    return inertia
