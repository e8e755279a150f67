"""What all nodes share: lifecycle, parameters, topics, spinning, network exposure."""
