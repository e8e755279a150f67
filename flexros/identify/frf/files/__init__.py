"""Frequency responses as labelled arrays and as files."""
