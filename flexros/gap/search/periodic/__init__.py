"""Rival hypotheses that repeat: the orders of harmonics, their overtones, and a search beside a line."""
