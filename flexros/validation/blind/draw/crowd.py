"""Effects of a crowd: many at once, most of them friction, at some of the motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.plant.laws import LIBRARY_LAWS, OUTSIDE_LAWS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy as np

    from flexros.robot import Robot

FEWEST, MOST = 3, 12
"""Numbers of effects of a crowd (the requirement)."""
PER_MOTOR, ELSEWHERE = 4, 2
"""Most effects per motor of a crowd, and how many more there may be on the whole robot (chosen)."""
PLAIN_FRICTION = ("viscous_friction", "coulomb_friction")
"""Friction that nearly every real joint has."""
PLAIN_SHARE = 0.5
"""Share of plain friction among the effects of a crowd (chosen)."""
NOT_IN_CROWDS = ("kinematic_error",)
"""Effects that no crowd holds: the motors do not show them."""
ALIKE = (
    {"coulomb_friction", "presliding_friction", "friction_drift", "load_dependent_friction"},
    {"viscous_friction", "friction_drift"},
    {"stribeck_friction", "presliding_friction", "friction_drift"},
    {"torque_gain_error", "motor_inertia_error"},
    {"delay", "actuator_lag"},
    {"backlash", "hysteresis", "nonlinear_stiffness", "stiffness_error"},
)
"""Effects of which no two sit at one motor, because they would explain each other."""

_RANKS: Mapping[str, int] = {"torque_saturation": -3, "torque_gain_error": -2, "actuator_lag": -1}
"""Order of effects between command and motor, as in the library; torques at the motor come after them."""


def draw_crowd(robot: Robot, outside: bool, random: np.random.Generator) -> tuple[tuple[str, str], ...]:
    """Draw what is hidden together.

    Args:
        robot: The robot.
        outside: Whether one cause outside the library is among it.
        random: Random numbers.

    Returns:
        Effects and their locations, in the order in which a plant applies them.
    """
    m = robot.n_motors
    motors = sorted(int(one) for one in random.permutation(m)[: int(random.integers(1, m + 1))])
    size = int(random.integers(FEWEST, min(MOST, PER_MOTOR * len(motors) + ELSEWHERE) + 1))
    names = [name for name in LIBRARY_LAWS if name not in NOT_IN_CROWDS]
    rare = [name for name in names if name not in PLAIN_FRICTION]
    found: list[tuple[str, str]] = []
    if outside:
        name = str(random.choice(list(OUTSIDE_LAWS)))
        found += _placed(name, robot, motors, random)
    while len(found) < size:
        name = str(random.choice(PLAIN_FRICTION if random.uniform() < PLAIN_SHARE else rare))
        found += [one for one in _placed(name, robot, motors, random) if _fits(one, found, robot)]
    order = [*LIBRARY_LAWS, *OUTSIDE_LAWS]
    return tuple(sorted(found, key=lambda one: (_RANKS.get(one[0], 0), order.index(one[0]), one[1])))


def _placed(name: str, robot: Robot, motors: Sequence[int], random: np.random.Generator) -> list[tuple[str, str]]:
    """Draw a location at one of the motors, or of the robot as a whole; none where there is none."""
    sites = {place: _site(place, robot) for place in places_of(name, robot)}
    places = [place for place, here in sites.items() if isinstance(here, str) or here in motors]
    return [(name, str(random.choice(places)))] if places else []


def _fits(one: tuple[str, str], others: Sequence[tuple[str, str]], robot: Robot) -> bool:
    """Whether an effect is no second one of its kind at a site, nor of a group that explain each other."""
    here = _site(one[1], robot)
    for name, place in others:
        there = _site(place, robot)
        if here != there and "all" not in (here, there):
            continue
        if name == one[0] or any({name, one[0]} <= group for group in ALIKE):
            return False
    return True


def _site(place: str, robot: Robot) -> int | str:
    """Return the number of the motor at a location, its own or that of its gear; else the location itself."""
    for number, motor in enumerate(robot.motors):
        if place in (motor.name, motor.joint.name):
            return number
    return place
