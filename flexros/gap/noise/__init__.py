"""What the sensors contribute to prediction errors, and the weights that follow."""
