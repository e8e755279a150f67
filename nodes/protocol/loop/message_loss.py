"""Deliberate message loss, for tests of the protocol."""

from __future__ import annotations

from random import Random


class MessageLoss:
    """Drops a fixed share of the messages that a node receives in the loop, repeatable by a seed.

    Args:
        fraction: Share of messages dropped, from 0 to below 1 [1].
        seed: Seed of the random generator.

    Attributes:
        dropped: Messages dropped so far.
    """

    def __init__(self, fraction: float, seed: int) -> None:
        self.dropped = 0
        self._fraction = fraction
        self._random = Random(seed).random  # noqa: S311 - a share of messages, not a secret

    def drops(self) -> bool:
        """Decide whether to drop the next message."""
        if self._fraction and self._random() < self._fraction:
            self.dropped += 1
            return True
        return False
