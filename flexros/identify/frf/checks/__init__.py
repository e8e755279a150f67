"""Checks of a record and its frequency response for errors that the estimate itself does not show."""
