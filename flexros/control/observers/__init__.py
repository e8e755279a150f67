"""Observers of the states of motors and links: one per file, chosen by the key `observer` of a controller."""
