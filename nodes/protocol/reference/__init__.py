"""References and trajectories: checked, streamed ahead and sampled."""
