"""What was left out of a log: how often, and why the first time; the reasons of millions of messages are not kept."""

from __future__ import annotations


class LeftOut:
    """Counts what was left out.

    Attributes:
        number: How often something was left out.
        first: Why it was the first time.
    """

    def __init__(self) -> None:
        self.number = 0
        self.first = ""

    def add(self, reason: str, number: int = 1) -> None:
        """Note what was left out.

        Args:
            reason: Why.
            number: How much.
        """
        self.first = self.first or reason
        self.number += number
