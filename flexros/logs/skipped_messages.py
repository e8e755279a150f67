"""Count of messages that were left out, with the first reason; the reasons of millions of messages are not kept."""

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
