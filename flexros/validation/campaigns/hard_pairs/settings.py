"""Settings of the hard pairs: pairs, sizes and the short log."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

ROBOT = "four_mass_linear"
SHORT: Mapping[str, Any] = {"diagnosis.parts": ["moves"], "diagnosis.length": 10, "diagnosis.intensity": 0.1}
"""Keys of scenario `diagnosis` for a log of gentle moves alone, which excites little (chosen)."""
PAIRS: Mapping[str, tuple[str, ...]] = {
    "delay, actuator_lag": ("delay@motor_1:time=0.0001", "actuator_lag@motor_1:time_constant=0.0001"),
    "motor_inertia_error, torque_gain_error": (
        "motor_inertia_error@motor_1:relative=0.001",
        "torque_gain_error@motor_1:relative=-0.00005",
    ),
    "backlash, hysteresis": (
        "backlash@motor_1:gap=6e-05",
        "backlash@motor_1:gap=0.0001",
        "hysteresis@motor_1:level=0.004,angle=0.0006",
        "hysteresis@motor_1:level=0.006,angle=0.0009",
    ),
}
"""Truths of each pair, one after the other; their sizes are near those at which such a log shows them (chosen)."""


@dataclass(frozen=True)
class HardPairsSettings:
    """Settings of the campaign.

    Attributes:
        robot: Name of the robot.
        pairs: Truths by pair.
        short: Keys of scenario `diagnosis` for the log that does not separate.
        duration: Length that is used of that log [s].
        seed: Seed of that log.
    """

    robot: str = ROBOT
    pairs: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: dict(PAIRS))
    short: Mapping[str, Any] = field(default_factory=lambda: dict(SHORT))
    duration: float = 9.0
    seed: int = 1
