"""Rivals of an explanation: which of them the patch holds, and what they say of its sizes."""
