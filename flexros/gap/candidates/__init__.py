"""Candidate causes: effects, locations, free parameters and their scales."""
