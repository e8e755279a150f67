"""Sensor noise in the prediction errors, and the resulting weights."""
