"""Campaign of crowds: does the diagnosis name many effects at once?"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.crowds.settings import CrowdSettings
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "crowds.md", "data/crowds.json"


class BlindCrowds(AbstractCampaign):
    """The blind check of crowds, or the first part of it.

    `--repetitions N` works on the first N cases of the plan, which are a fair sample of it; a larger N goes on.

    Args:
        settings: Seed, plan and lengths.
    """

    name: ClassVar[str] = "crowds"
    question: ClassVar[str] = "Does the diagnosis name all of 3 to 12 hidden effects, and nothing else?"

    def __init__(self, settings: CrowdSettings | None = None) -> None:
        self._settings = settings or CrowdSettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.validation.blind.make_case import MakeSettings
        from flexros.validation.blind.plan import plan_cases
        from flexros.validation.campaigns.blind.case_part import answer_of, case_part

        settings = self._settings
        claim_folder(request.work, asdict(settings))
        plan = plan_cases(settings.plan, settings.seed, settings.stream)
        chosen = plan[: request.repetitions or len(plan)]
        made = MakeSettings(settings.seed, settings.stream, settings.durations)
        parts = finished_parts(
            request.work,
            request.client,
            {case.name: (made, case) for case in chosen},
            case_part,
            lambda done: request.progress("crowds", done, len(chosen)),
        )
        answers = [answer_of(name, part) for name, part in parts.items()]
        failures = {name: part["failure"] for name, part in parts.items() if part["failure"]}
        return crowds_result(answers, failures, len(plan), settings, versions_of(parts.values()))


def crowds_result(
    answers: Sequence[Answer],
    failures: dict[str, str],
    planned: int,
    settings: CrowdSettings,
    used: dict[str, str],
) -> CampaignResult:
    """Count and write the page.

    Args:
        answers: The cases as scored.
        failures: What stopped a diagnosis, by name of the case.
        planned: Number of cases of the whole plan.
        settings: Settings of the campaign.
        used: Versions of packages and code.

    Returns:
        Page, figures and summary.
    """
    from flexros.json_text import json_text
    from flexros.validation.blind.score.crowd_tables import crowd_groups
    from flexros.validation.blind.score.crowds import crowd_score
    from flexros.validation.campaigns.crowds.page import crowds_page, crowds_summary

    groups = {name: some for name, some in crowd_groups(answers).items() if some}
    figures: dict[str, Any] = {
        "settings": json.loads(json.dumps(asdict(settings))),
        "planned": planned,
        "scores": {name: asdict(crowd_score(some)) for name, some in {"all": answers, **groups}.items()},
        "cases": [crowd_row(one) for one in answers],
        "failures": failures,
        "versions": used,
    }
    files = {PAGE: crowds_page(answers, failures, planned, settings, used), FIGURES: json_text(figures)}
    return CampaignResult(files, figures, crowds_summary(answers, planned))


def crowd_row(one: Answer) -> dict[str, Any]:
    """Put truth and answer of a case into a row for JSON.

    Args:
        one: The case.
    """
    diagnosis = one.diagnosis
    causes = () if diagnosis is None else diagnosis.causes
    return {
        **one.truth.model_dump(mode="json", exclude={"salt", "robot_sha256", "conditions"}),
        "verdict": None if diagnosis is None else diagnosis.verdict,
        "causes": [cause.model_dump(mode="json") for cause in causes],
        "budget": [] if diagnosis is None else [row.model_dump(mode="json", by_alias=True) for row in diagnosis.budget],
        "true": None if one.crowd is None else one.crowd.model_dump(mode="json"),
        "closed": one.closed,
        "third": None if one.third is None else one.third.model_dump(mode="json"),
        "seconds": one.seconds,
    }
