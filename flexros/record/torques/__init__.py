"""Torques of a record: held and shifted in time, of servos, without the noise of their measurement."""
