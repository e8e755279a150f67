"""Servos under position commands: what a search of their logs begins with."""
