"""Friction of motors."""
