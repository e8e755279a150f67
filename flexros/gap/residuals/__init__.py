"""Weighted prediction errors of a log."""
