"""Rival hypotheses: every effect at every location, pairs, and their probabilities."""
