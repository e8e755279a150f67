"""Noise floors of a robot: sizes of effects that its encoders would just show.

The floor of a motor angle, and of a deflection of its gear, is the noise of its encoder; that of a speed the noise in
0.1 s; that of a torque the constant torque that moves the motor by the noise within 0.1 s, with the rigid inertia that
it sees at home while the other motors stand still: 2 J noise / t^2. Other quantities have none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects.kinds.base import AbstractEffect
    from flexros.robot import Robot

TIME = 0.1
"""Time in which a floor is reached [s] (chosen)."""
WORD = "floors"
"""How sizes in floors end: level=12floors."""
QUANTITIES = ("torque", "speed", "angle", "deflection")
"""Scales of ranges that have a floor."""


def check_has_floor(effect: type[AbstractEffect], parameter: str, source: str) -> None:
    """Refuse a size in floors of a parameter that has no floor.

    Args:
        effect: The effect.
        parameter: Name of its parameter.
        source: Where it came from; opens the error text.

    Raises:
        InputError: Names the parameter and what has a floor.
    """
    measured = effect.ranges.get(parameter)
    if measured is None or measured.scale not in QUANTITIES:
        raise InputError(
            f"{source}: parameter '{parameter}' is given in noise floors, but only torques, speeds, motor angles and "
            "deflections of gears have one; give it as a number"
        )


def floor_of(robot: Robot, effect: type[AbstractEffect], parameter: str, location: str) -> float:
    """Compute the noise floor of a parameter.

    Args:
        robot: The robot without effects.
        effect: The effect.
        parameter: Name of its parameter, one that has a floor.
        location: Place of the effect: a motor or the spring of its gear.

    Returns:
        The floor [unit of the parameter].

    Raises:
        InputError: There is no motor at the place, or its encoder has no noise.
    """
    source = f"{effect.name}@{location}: parameter '{parameter}'"
    springs = {robot.joints[arm].name: motor for motor, arm in enumerate(robot.gear_rows)}
    motors = {name: motor for motor, name in enumerate(robot.joint_names)}
    motor = (springs | motors).get(location)
    if motor is None:
        raise InputError(
            f"{source} is given in noise floors, but {location} has no motor with an encoder; give it as a number"
        )
    noise = float(robot.encoder_noise[motor])
    if noise <= 0:
        raise InputError(
            f"{source} is given in noise floors, but the encoder of motor_{motor + 1} of robot {robot.name} has no "
            "noise; give it as a number"
        )
    quantity = effect.ranges[parameter].scale
    if quantity == "torque":
        return 2 * float(rigid_inertia(robot)[motor]) * noise / TIME**2
    return noise / TIME if quantity == "speed" else noise


def rigid_inertia(robot: Robot) -> FloatArray:
    """Compute the inertia that each motor moves at home, springs rigid and the other motors held.

    Args:
        robot: The robot.

    Returns:
        Inertias [kg m2 or kg], shape (M,).
    """
    arm = np.diag(np.array(robot.model.arm_inertia(robot.home, robot.model.parameter_values)))
    motors = [robot.parameters[f"{name}.inertia"].value for name in robot.joint_names]
    inertia: FloatArray = arm[list(robot.gear_rows)] + np.array(motors)
    return inertia
