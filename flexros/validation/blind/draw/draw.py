"""Drawing deviations: location, shape, and the parameter that sets their size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.validation.blind.deviation import Deviation

if TYPE_CHECKING:
    from flexros.validation.blind.draw.scales import Scales

Numbers: TypeAlias = dict[str, float]


@dataclass(frozen=True, eq=False)
class Draft:
    """A deviation whose size is still open.

    Attributes:
        effect: Its name.
        location: Its place.
        shape: Its numbers for a size; size 1 is small.
        largest: Largest size that is physical.
    """

    effect: str
    location: str
    shape: Callable[[float], Numbers]
    largest: float

    def at(self, size: float) -> Deviation:
        """Return the deviation of a size."""
        numbers = {name: float(value) for name, value in self.shape(size).items()}
        return Deviation(effect=self.effect, location=self.location, parameters=numbers)


def even(one: Draft) -> Draft:
    """Return a friction that is the same in both directions."""
    return replace(one, shape=lambda size: {**one.shape(size), "asymmetry": 0.0})


Drawer: TypeAlias = Callable[["Site", np.random.Generator], tuple[Callable[[float], Numbers], float]]
"""Draws the shape of an effect at a site, and its largest size."""


@dataclass(frozen=True, eq=False)
class Site:
    """A location on a robot and its scales.

    Attributes:
        scales: Scales of the robot's motion.
        location: Name of the place.
        motor: Number of the motor there; 0 where the place is none.
        joint: Number of the arm joint there; the last one at the tool.
    """

    scales: Scales
    location: str
    motor: int
    joint: int

    @property
    def torque(self) -> float:
        """Largest torque of the motor [Nm or N]."""
        return float(self.scales.torque[self.motor])

    @property
    def speed(self) -> float:
        """Largest speed of the motor [rad/s]."""
        return float(self.scales.speed[self.motor])

    @property
    def deflection(self) -> float:
        """Largest deflection at the joint [rad]."""
        return float(self.scales.deflection[self.joint])

    @property
    def noise(self) -> float:
        """Encoder noise [rad]."""
        return float(self.scales.robot.encoder_noise[self.motor])

    def order(self, random: np.random.Generator) -> float:
        """Draw an order that has several periods on the way of the motor [1]."""
        robot = self.scales.robot
        turns = robot.motors[self.motor].gear_ratio if robot.spec.coordinates == "arm" else 1.0
        order = float(random.choice([1, 2, 3, 4, 6, 8, 12, 24]))
        return order if turns > 1 or robot.spec.coordinates == "motor" else 100.0 * order


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is even between two ends."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def sign(random: np.random.Generator) -> float:
    """Draw a sign."""
    return float(random.choice([-1.0, 1.0]))


def site(scales: Scales, location: str) -> Site:
    """Find motor and joint of a location."""
    robot = scales.robot
    if location in robot.joint_names:
        motor = robot.joint_names.index(location)
        return Site(scales, location, motor, robot.gear_rows[motor])
    if location in robot.arm_names:
        joint = robot.arm_names.index(location)
        return Site(scales, location, robot.joints[joint].motor or 0, joint)
    joint = robot.n_arm - 1 if location == "tool" else 0
    return Site(scales, location, 0, joint)


def draft(
    drawers: Mapping[str, Drawer], effect: str, scales: Scales, location: str, random: np.random.Generator
) -> Draft:
    """Draw an effect at a location.

    Args:
        drawers: How effects are drawn, by name.
        effect: Name of the effect.
        scales: Scales of the robot's motion.
        location: Its place.
        random: Random numbers.

    Returns:
        The effect with its size open.
    """
    shape, largest = drawers[effect](site(scales, location), random)
    return Draft(effect, location, shape, largest)
