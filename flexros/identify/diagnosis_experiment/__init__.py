"""The diagnosis experiment: a reference sequence for any robot that reveals its deviations from the model."""
