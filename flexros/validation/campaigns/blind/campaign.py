"""Campaign of the blind check: does the diagnosis find hidden deviations in unseen logs?"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.blind.settings import BlindSettings
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "blind.md", "data/blind.json"


class BlindCheck(AbstractCampaign):
    """The blind check of DESIGN's section 10, or the first part of it.

    `--repetitions N` works on the first N cases of the plan, which are a fair sample of it; a larger N goes on.

    Args:
        settings: Seed, plan and lengths.
    """

    name: ClassVar[str] = "blind"
    question: ClassVar[str] = "Does the diagnosis name what is hidden in logs it has never seen, and nothing else?"

    def __init__(self, settings: BlindSettings | None = None) -> None:
        self._settings = settings or BlindSettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.validation.blind.make_case import MakeSettings
        from flexros.validation.blind.plan import plan_cases
        from flexros.validation.campaigns.blind.case_part import answer_of, case_part

        settings = self._settings
        claim_folder(request.work, asdict(settings))
        plan = plan_cases(settings.plan, settings.seed)
        chosen = plan[: request.repetitions or len(plan)]
        made = MakeSettings(settings.seed, durations=settings.durations)
        parts = finished_parts(
            request.work,
            request.client,
            {case.name: (made, case) for case in chosen},
            case_part,
            lambda done: request.progress("cases", done, len(chosen)),
        )
        answers = [answer_of(name, part) for name, part in parts.items()]
        failures = {name: part["failure"] for name, part in parts.items() if part["failure"]}
        return blind_result(answers, failures, len(plan), settings, versions_of(parts.values()))


def blind_result(
    answers: Sequence[Answer],
    failures: dict[str, str],
    planned: int,
    settings: BlindSettings,
    used: dict[str, str],
) -> CampaignResult:
    """Count and write the pages.

    Args:
        answers: The cases as scored.
        failures: What stopped a diagnosis, by name of the case.
        planned: Number of cases of the whole plan.
        settings: Settings of the campaign.
        used: Versions of packages and code.

    Returns:
        Pages, pictures, figures and summary.
    """
    from flexros.json_text import json_text
    from flexros.validation.blind.score.score import record
    from flexros.validation.campaigns.blind.page import blind_page, blind_summary
    from flexros.validation.campaigns.blind.pictures import pictures

    drawn = pictures(answers)
    figures: dict[str, Any] = {
        "settings": json.loads(json.dumps(asdict(settings))),
        "planned": planned,
        "scores": record(answers),
        "cases": [case_row(one) for one in answers],
        "failures": failures,
        "versions": used,
    }
    files = {PAGE: blind_page(answers, failures, planned, settings, drawn, used), FIGURES: json_text(figures)}
    files |= {f"figures/blind_{name}.svg": text for name, text in drawn.items()}
    return CampaignResult(files, figures, blind_summary(answers, planned))


def case_row(one: Answer) -> dict[str, Any]:
    """Put truth and answer of a case into a row for JSON.

    Args:
        one: The case.
    """
    truth, diagnosis = one.truth, one.diagnosis
    return {
        **truth.model_dump(mode="json", exclude={"salt", "robot_sha256", "conditions"}),
        "verdict": None if diagnosis is None else diagnosis.verdict,
        "causes": [[cause.effect, cause.location, round(cause.probability, 4)] for cause in one.causes[:3]],
        "group_size": one.group_size,
        "closed": one.closed,
        "closed_rival": one.closed_rival,
        "closed_third": one.closed_third,
        "seconds": one.seconds,
    }
