"""The command `flexros design`."""
