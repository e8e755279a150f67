"""Compensation of effects in the reference, and what cannot be compensated."""
