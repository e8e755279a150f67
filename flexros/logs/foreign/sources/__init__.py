"""File formats of foreign logs, one per file, found by discovery."""
