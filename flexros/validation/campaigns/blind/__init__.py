"""Blind check of the gap diagnosis: logs with hidden deviations, diagnosed without their truth."""

from flexros.validation.campaigns.blind.campaign import BlindCheck

__all__ = ["BlindCheck"]
