"""Sizes of the motions of a diagnosis experiment, from the parameters of the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.config.per_motor import per_motor
from flexros.errors import InputError
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.config.per_motor import PositivePerMotor
    from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
    from flexros.robot import Robot

REACH = {True: 0.4, False: 0.1}
"""Distance of a joint from its initial position, by whether it rotates [rad or m on the arm's side] (chosen)."""
SPEED = {True: 1.5, False: 0.5}
"""Largest speed [rad/s or m/s on the arm's side] (chosen for a robot of medium size)."""
ACCELERATION = {True: 5.0, False: 2.0}
"""Acceleration of a robot without torque limits [rad/s^2 or m/s^2 on the arm's side] (chosen)."""
FASTEST = {True: 15.0, False: 10.0}
"""Largest acceleration of any robot [rad/s^2 or m/s^2 on the arm's side] (chosen)."""
TURNS = 2.5
"""Turns of the rotor over the creep stroke, where the reach permits [1] (chosen: over two, so that orders repeat)."""
CREEP = {True: 0.1, False: 0.03}
"""Creep stroke of a robot whose gear ratio is not known [rad or m on the arm's side] (chosen)."""
TORQUE_SHARE = 0.75
"""Share of the torque limits that the experiment uses, loads at rest included [1] (chosen)."""
NOISE_MULTIPLE = 30.0
"""Smallest slow reversal as a multiple of the encoder noise [1] (chosen)."""
SMALLEST_SHARE = 1e-4
"""Least slow reversal as a share of the creep stroke, also for robot files without encoder noise [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class Scales:
    """Sizes of the motion of every motor, on the side of the gear that the robot file uses.

    Attributes:
        reach: Largest distance from the initial position [rad or m], shape (M,).
        speed: Largest speed [rad/s or m/s], shape (M,).
        acceleration: Largest acceleration [rad/s^2 or m/s^2], shape (M,).
        torque: Torque of that acceleration on the rigid robot [Nm or N], shape (M,).
        inertia: Inertia matrix of the rigid robot in its gears [kg m^2 or kg], shape (M, M).
        creep: Stroke of the creep [rad or m], shape (M,).
        smallest: Smallest slow reversal [rad or m], shape (M,).
    """

    reach: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    torque: FloatArray
    inertia: FloatArray
    creep: FloatArray
    smallest: FloatArray


def scales_of(specification: DiagnosisSpecification, robot: Robot, arm: FloatArray) -> Scales:
    """Choose the sizes.

    Speed and reach are those of a robot of medium size unless given. The acceleration is what the torque limits permit
    in addition to the load at rest, with all motors at once, or a usual value where there are no limits.

    Args:
        specification: Length, parts and sizes.
        robot: The nominal robot.
        arm: Initial arm coordinates [rad or m], shape (N,).

    Raises:
        InputError: A setting has not one value per motor, or the torque limits cannot hold the robot at rest.
    """
    rotary = [motor.rotary for motor in robot.motors]
    ratio = np.array([motor.gear_ratio for motor in robot.motors])
    on_motor_side = robot.spec.coordinates == "motor"
    side = ratio if on_motor_side else np.ones_like(ratio)
    usual = {
        name: side * np.array([table[kind] for kind in rotary])
        for name, table in (("reach", REACH), ("speed", SPEED), ("acceleration", ACCELERATION), ("creep", CREEP))
    }
    reach = _given("reach", specification.reach, usual["reach"])
    turns = TURNS * 2.0 * np.pi * (np.ones_like(ratio) if on_motor_side else 1.0 / ratio)
    creep = np.minimum(np.where(ratio == 1.0, usual["creep"], turns), reach)
    creep = _given("creep", specification.creep, creep)
    inertia = _rigid_inertia(robot, arm)
    acceleration = _acceleration(robot, arm, inertia, usual["acceleration"])
    acceleration = np.minimum(acceleration, side * np.array([FASTEST[kind] for kind in rotary]))
    acceleration = _given("acceleration", specification.acceleration, acceleration)
    return Scales(
        reach=reach,
        speed=_given("speed", specification.speed, usual["speed"]),
        acceleration=acceleration,
        torque=np.abs(inertia) @ acceleration,
        inertia=inertia,
        creep=creep,
        smallest=np.clip(NOISE_MULTIPLE * robot.encoder_noise, SMALLEST_SHARE * creep, 0.1 * creep),
    )


def _given(key: str, value: PositivePerMotor | None, usual: FloatArray) -> FloatArray:
    """Return the given size, else the usual one."""
    return usual if value is None else per_motor(f"diagnosis.{key}", value, len(usual))


def _acceleration(robot: Robot, arm: FloatArray, inertia: FloatArray, usual: FloatArray) -> FloatArray:
    """Accelerations that all motors can have at once; the usual ones for motors without torque limit."""
    load = np.abs(robot.holding_torque(robot.equilibrium(arm)))
    room = TORQUE_SHARE * robot.torque_limits - load
    if np.any(room <= 0.0):
        motor = int(np.argmin(room))
        raise InputError(
            f"diagnosis: {robot.joint_names[motor]} needs {load[motor]:.4g} to hold the initial pose, allowed are "
            f"{TORQUE_SHARE:g} times its torque limit, {TORQUE_SHARE * robot.torque_limits[motor]:.4g}; choose another "
            "start"
        )
    limited = np.isfinite(room)
    wanted = np.where(limited, np.where(limited, room, 0.0) / np.diag(inertia), usual)
    required = np.abs(inertia) @ wanted
    factor = np.where(limited, np.where(limited, room, 1.0) / required, 1.0)
    result: FloatArray = wanted * np.min(factor)
    return result


def _rigid_inertia(robot: Robot, arm: FloatArray) -> FloatArray:
    """Inertia of arm and motors in the gears, all springs rigid, shape (M, M)."""
    linear = linear_model(robot, arm)
    shape = np.zeros((robot.n_coordinates, robot.n_motors))
    for motor, (gear, rotor) in enumerate(zip(robot.gear_rows, robot.motor_rows, strict=True)):
        shape[[gear, rotor], motor] = 1.0
    inertia: FloatArray = shape.T @ linear.mass @ shape
    return inertia
