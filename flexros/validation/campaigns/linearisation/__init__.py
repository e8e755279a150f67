"""Study: feedback linearisation against feedforward, under model errors, delay, noise and disturbances."""

from flexros.validation.campaigns.linearisation.campaign import Linearisation

__all__ = ["Linearisation"]
