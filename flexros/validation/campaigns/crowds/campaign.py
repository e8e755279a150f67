"""Campaign of crowds: does the diagnosis name many effects at once?"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.validation.campaigns.blind_campaign import AbstractBlindCampaign, Written
from flexros.validation.campaigns.crowds.settings import CrowdSettings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.blind_campaign import ScoredCases


class BlindCrowds(AbstractBlindCampaign[CrowdSettings]):
    """The blind check of crowds, or the first part of it; see `AbstractBlindCampaign`."""

    name: ClassVar[str] = "crowds"
    question: ClassVar[str] = "Does the diagnosis name all of 3 to 12 hidden effects, and nothing else?"
    cases: ClassVar[str] = "crowds"

    def __init__(self, settings: CrowdSettings | None = None) -> None:
        super().__init__(settings or CrowdSettings())

    def scores(self, answers: Sequence[Answer]) -> dict[str, Any]:
        """Count hits and misses, also by group; see `AbstractBlindCampaign.scores`."""
        from flexros.validation.blind.score.crowd_tables import crowd_groups
        from flexros.validation.blind.score.crowds import crowd_score

        groups = {name: some for name, some in crowd_groups(answers).items() if some}
        return {name: asdict(crowd_score(some)) for name, some in {"all": answers, **groups}.items()}

    def row(self, one: Answer) -> dict[str, Any]:
        """Put truth and answer of a case into a row; see `AbstractBlindCampaign.row`."""
        diagnosis = one.diagnosis
        causes = () if diagnosis is None else diagnosis.causes
        return {
            **one.truth.model_dump(mode="json", exclude={"salt", "robot_sha256", "conditions"}),
            "verdict": None if diagnosis is None else diagnosis.verdict,
            "causes": [cause.model_dump(mode="json") for cause in causes],
            "budget": []
            if diagnosis is None
            else [row.model_dump(mode="json", by_alias=True) for row in diagnosis.budget],
            "true": None if one.crowd is None else one.crowd.model_dump(mode="json"),
            "closed": one.closed,
            "third": None if one.third is None else one.third.model_dump(mode="json"),
            "seconds": one.seconds,
        }

    def written(self, found: ScoredCases) -> Written:
        """Write page and summary; see `AbstractBlindCampaign.written`."""
        from flexros.validation.campaigns.crowds.page import crowds_page, crowds_summary

        page = crowds_page(found.answers, found.failures, found.planned, self.settings, found.used)
        return Written(page, crowds_summary(found.answers, found.planned))
