"""Effects put onto a robot: placement, patch files, patched robots."""
