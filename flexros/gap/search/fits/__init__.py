"""Fits to one log: how they begin and end, refits of an explanation, and the candidates around it."""
