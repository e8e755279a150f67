"""Common part of all nodes: lifecycle, parameters, topics, spinning, network exposure."""
