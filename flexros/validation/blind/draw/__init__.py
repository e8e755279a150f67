"""Draws of a blind case: deviations, sizes, references, controllers, conditions."""
