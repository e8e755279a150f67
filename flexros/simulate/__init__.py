"""Simulated plants in time: robot with effects, disturbances and sensor noise."""
