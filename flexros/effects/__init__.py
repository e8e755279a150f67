"""Deviations of a real robot from the ideal model, one per file, found by themselves."""

from flexros.effects.base import AbstractEffect, PlacedEffect, effects, parse_effect, plant_values

__all__ = ["AbstractEffect", "PlacedEffect", "effects", "parse_effect", "plant_values"]
