"""Count of skipped messages, with the first reason only, so that memory is bounded."""

from __future__ import annotations


class SkippedMessages:
    """Counter of left-out messages.

    Attributes:
        number: Number of left-out messages.
        first: Reason for the first one.
    """

    def __init__(self) -> None:
        self.number = 0
        self.first = ""

    def add(self, reason: str, number: int = 1) -> None:
        """Count messages that were left out for a reason."""
        self.first = self.first or reason
        self.number += number
