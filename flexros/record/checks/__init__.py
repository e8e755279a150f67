"""Checks of a record for errors that would mislead diagnosis and identification: one per file, found by discovery."""
