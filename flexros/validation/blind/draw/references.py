"""References that differ from case to case: rests, slow reversals, fast moves and multisines in random order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

REACH_MOTOR, REACH_ARM = 30.0, 0.4
"""Way from home, either side, of robots stated on the motor side and on the arm side [rad] (chosen)."""
TORQUE_SHARE = 0.3
"""Share of the torque limit that accelerations need (chosen)."""
ACCELERATION = 4.0
"""Acceleration of robots without torque limit [rad/s2] (chosen)."""
FADE = 0.3
"""Time over which a multisine swells and fades [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class Room:
    """Room that a reference may use.

    Attributes:
        middle: Motor positions at home [rad], shape (M,).
        reach: Largest way from there [rad].
        acceleration: Largest acceleration of each motor [rad/s2], shape (M,).
    """

    middle: FloatArray
    reach: float
    acceleration: FloatArray


def room_of(robot: Robot) -> Room:
    """Find how far and how fast a robot is moved.

    Args:
        robot: The robot.

    Returns:
        Its room.
    """
    rest = robot.equilibrium(robot.home)
    acceleration = TORQUE_SHARE * robot.torque_limits / rigid_inertia(robot)
    acceleration = np.where(np.isfinite(acceleration), acceleration, ACCELERATION)
    reach = REACH_MOTOR if robot.spec.coordinates == "motor" else REACH_ARM
    return Room(rest[list(robot.motor_rows)], reach, acceleration)


def rigid_inertia(robot: Robot) -> FloatArray:
    """Return the inertia of each motor at home, the others at rest and all springs rigid [kg m2], shape (M,)."""
    q = robot.equilibrium(robot.home)[: robot.n_coordinates]
    mass = np.asarray(robot.model.mass_matrix(q, robot.model.parameter_values))
    shape = np.zeros((robot.n_coordinates, robot.n_motors))
    for motor, (gear, own) in enumerate(zip(robot.gear_rows, robot.motor_rows, strict=True)):
        shape[[gear, own], motor] = 1.0
    return np.asarray(np.diag(shape.T @ mass @ shape))


def random_reference(room: Room, duration: float, sample_time: float, random: np.random.Generator) -> FloatArray:
    """Draw a reference.

    Args:
        room: Room that it may use.
        duration: Its length [s].
        sample_time: Time between two samples [s].
        random: Random numbers.

    Returns:
        Motor positions [rad], shape (n, M).
    """
    n = round(duration / sample_time) + 1
    kinds: tuple[Callable[..., FloatArray], ...] = (_rest, _slow, _move, _move, _multisine)
    order = [random.permutation(len(kinds)) for _ in range(200)]
    position, at = room.middle.copy(), 0
    pieces = []
    for kind in np.concatenate(order):
        piece = kinds[int(kind)](room, position, sample_time, random)
        pieces.append(piece)
        at, position = at + len(piece), piece[-1]
        if at >= n:
            break
    return np.concatenate(pieces)[:n]


def _rest(room: Room, start: FloatArray, step: float, random: np.random.Generator) -> FloatArray:
    return np.repeat(start[None], max(1, round(random.uniform(0.4, 1.2) / step)), axis=0)


def _slow(room: Room, start: FloatArray, step: float, random: np.random.Generator) -> FloatArray:
    """Swing slowly to both sides and back, so that every motor turns round often."""
    period, cycles = random.uniform(1.0, 2.5), 2
    time = np.arange(1, round(cycles * period / step) + 1) * step
    size = room.reach * random.uniform(0.01, 0.06, len(start))
    swell = np.sin(np.pi * time / (cycles * period)) ** 2
    wave = np.sin(2 * np.pi * time[:, None] / period * random.choice([1, 2], len(start)))
    return np.asarray(start + size * swell[:, None] * wave)


def _move(room: Room, start: FloatArray, step: float, random: np.random.Generator) -> FloatArray:
    """Move to another position on a polynomial of 5th degree, fast or slowly."""
    goal = room.middle + room.reach * random.uniform(-1.0, 1.0, len(start))
    acceleration = room.acceleration * random.choice([1.0, 0.3], p=[0.7, 0.3])
    duration = float(np.sqrt(np.max(5.78 * np.abs(goal - start) / acceleration)))
    x = (np.arange(1, round(duration / step) + 1) * step / duration)[:, None]
    return np.asarray(start + (goal - start) * (10 * x**3 - 15 * x**4 + 6 * x**5))


def _multisine(room: Room, start: FloatArray, step: float, random: np.random.Generator) -> FloatArray:
    """Odd random-phase multisine of flat acceleration, two periods, around the present position."""
    period, high = 2.0, random.uniform(25.0, 60.0)
    lines = np.arange(3, round(high * period), 2)
    time = np.arange(1, round(2 * period / step) + 1) * step
    size = room.acceleration * random.choice([0.05, 0.15, 0.3])
    phases = random.uniform(0.0, 2 * np.pi, (len(start), len(lines)))
    speed = 2 * np.pi * lines / period
    waves = np.stack([np.cos(time[:, None] * speed + one) @ (1 / speed**2) for one in phases], axis=1)
    swell = np.clip(np.minimum(time, time[-1] - time) / FADE, 0, 1)
    swell = swell**3 * (10 - 15 * swell + 6 * swell**2)
    return np.asarray(start + size * np.sqrt(2 / len(lines)) * waves * swell[:, None])
