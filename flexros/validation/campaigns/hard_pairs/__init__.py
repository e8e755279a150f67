"""Hard pairs: effects that a log cannot separate, and the experiment that does."""

from flexros.validation.campaigns.hard_pairs.campaign import HardPairs

__all__ = ["HardPairs"]
