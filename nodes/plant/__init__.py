"""Plant node: the simulated robot."""
