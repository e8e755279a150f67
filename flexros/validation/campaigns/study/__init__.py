"""The study of Paper A of Moberg (2007) repeated: six estimators, many starts, a robot that the model does not know."""

from flexros.validation.campaigns.study.campaign import PaperStudy

__all__ = ["PaperStudy"]
