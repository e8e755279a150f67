"""Lock-step loop of the plant: commands, pause, abort, shutdown and diagnostics."""
