"""Sensitivity: answers of the diagnosis with every setting halved and doubled."""

from flexros.validation.campaigns.sensitivity.campaign import Sensitivity

__all__ = ["Sensitivity"]
