"""Campaign of the blind check: does the diagnosis find hidden deviations in unseen logs?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from flexros.validation.campaigns.blind.settings import BlindSettings
from flexros.validation.campaigns.blind_campaign import AbstractBlindCampaign, Written

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.blind_campaign import ScoredCases


class BlindCheck(AbstractBlindCampaign[BlindSettings]):
    """The blind check of DESIGN's section 10, or the first part of it; see `AbstractBlindCampaign`."""

    name: ClassVar[str] = "blind"
    question: ClassVar[str] = "Does the diagnosis name what is hidden in logs it has never seen, and nothing else?"
    cases: ClassVar[str] = "cases"

    def __init__(self, settings: BlindSettings | None = None) -> None:
        super().__init__(settings or BlindSettings())

    def scores(self, answers: Sequence[Answer]) -> dict[str, Any]:
        """Count hits and misses; see `AbstractBlindCampaign.scores`."""
        from flexros.validation.blind.score.score import record

        return record(answers)

    def row(self, one: Answer) -> dict[str, Any]:
        """Put truth and answer of a case into a row; see `AbstractBlindCampaign.row`."""
        return {
            **one.truth.model_dump(mode="json", exclude={"salt", "robot_sha256", "conditions"}),
            "verdict": None if one.diagnosis is None else one.diagnosis.verdict,
            "causes": [[cause.effect, cause.location, round(cause.probability, 4)] for cause in one.causes[:3]],
            "group_size": one.group_size,
            "closed": one.closed,
            "closed_rival": one.closed_rival,
            "closed_third": one.closed_third,
            "seconds": one.seconds,
        }

    def written(self, found: ScoredCases) -> Written:
        """Write page, summary and pictures; see `AbstractBlindCampaign.written`."""
        from flexros.validation.campaigns.blind.page import blind_page, blind_summary
        from flexros.validation.campaigns.blind.pictures import pictures

        drawn = pictures(found.answers)
        page = blind_page(found.answers, found.failures, found.planned, self.settings, drawn, found.used)
        return Written(page, blind_summary(found.answers, found.planned), drawn)
