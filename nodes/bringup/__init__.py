"""Bring-up: all nodes of a run, composed or as processes, from a program or a launch file."""
