"""Deviations of a real robot from the ideal model, one per file, discovered by name."""

from flexros.effects.kinds.base import AbstractEffect, PlacedEffect, effects, parse_effect
from flexros.effects.patching.placement import PlacedLaw, RobotWithEffects, place_effects

__all__ = [
    "AbstractEffect",
    "PlacedEffect",
    "PlacedLaw",
    "RobotWithEffects",
    "effects",
    "parse_effect",
    "place_effects",
]
