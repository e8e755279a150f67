"""Effects applied to a robot: placement, patch files, patched robots."""
