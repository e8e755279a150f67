"""Formats that signals of a foreign log are read from, one per file, found by themselves."""
