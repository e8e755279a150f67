"""Checks of a record and its frequency response for errors that division hides."""
