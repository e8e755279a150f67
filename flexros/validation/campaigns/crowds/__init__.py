"""Blind crowds: logs with 3 to 12 hidden effects, diagnosed without their truth."""

from flexros.validation.campaigns.crowds.campaign import BlindCrowds

__all__ = ["BlindCrowds"]
