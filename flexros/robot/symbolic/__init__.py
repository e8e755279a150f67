"""The symbolic graph of a robot: chain, kinematics, dynamics, model."""
