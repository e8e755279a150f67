"""What an identified model is worth on the path of the real robot."""

from flexros.validation.campaigns.path_improvement.campaign import PathErrors

__all__ = ["PathErrors"]
