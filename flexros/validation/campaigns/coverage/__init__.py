"""Monte-Carlo check of an identification: do its intervals cover the truth, and how far off are its values?"""

from flexros.validation.campaigns.coverage.campaign import Coverage

__all__ = ["Coverage"]
