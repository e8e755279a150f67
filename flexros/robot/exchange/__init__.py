"""Robots in the formats of other programs."""
