"""A run as data, and the runs themselves: scenario, experiment, closed loop, batch."""
