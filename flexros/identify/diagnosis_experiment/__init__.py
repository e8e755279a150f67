"""The diagnosis experiment: one reference sequence, made for any robot, that shows its deviations from the model."""
