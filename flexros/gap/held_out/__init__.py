"""The gap between model and robot on data that was not fitted."""
