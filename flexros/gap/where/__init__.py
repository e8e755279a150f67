"""Locations of a gap, without assuming an effect: excess of prediction errors over noise, with p-values."""
