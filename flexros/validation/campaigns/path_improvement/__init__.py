"""Path errors of the real robot with the identified model."""

from flexros.validation.campaigns.path_improvement.campaign import PathErrors

__all__ = ["PathErrors"]
