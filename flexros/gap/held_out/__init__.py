"""How far model and robot are apart, on data that was not fitted."""
