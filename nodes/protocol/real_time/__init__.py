"""Real-time mode: schedule of the cycles, their statistics and precise waits."""
