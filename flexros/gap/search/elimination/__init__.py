"""Elimination: which effects an explanation does without, and which of those come back."""
