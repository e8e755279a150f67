"""The commands of `flexros identify`."""
