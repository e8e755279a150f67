"""Campaign: how do answers of the diagnosis move when its settings are halved and doubled?"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, ClassVar

from flexros.errors import unknown_name
from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of
from flexros.validation.campaigns.sensitivity.settings import NOT_VARIED, SensitivitySettings

if TYPE_CHECKING:
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "sensitivity.md", "data/sensitivity.json"


class Sensitivity(AbstractCampaign):
    """Diagnoses of fixed development cases, with one setting of the diagnosis changed at a time.

    `--repetitions N` works on the first N cases.

    Args:
        settings: Cases, factors and settings to vary.
    """

    name: ClassVar[str] = "sensitivity"
    question: ClassVar[str] = "How do answers of the diagnosis move when its settings are halved and doubled?"

    def __init__(self, settings: SensitivitySettings | None = None) -> None:
        self._settings = settings or SensitivitySettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.json_text import json_text
        from flexros.validation.blind.diagnose_case import case_settings
        from flexros.validation.campaigns.sensitivity.case_part import case_part
        from flexros.validation.campaigns.sensitivity.page import Study, sensitivity_page, sensitivity_summary
        from flexros.validation.campaigns.sensitivity.variation import numeric_keys

        settings, default = self._settings, case_settings()
        claim_folder(request.work, {**asdict(settings), "diagnosis": default.model_dump(mode="json")})
        values = numeric_keys(default, NOT_VARIED)
        for key in settings.keys:
            if key not in values:
                raise unknown_name("setting of the diagnosis", key, values, "the settings of the study")
        varied = {key: value for key, value in values.items() if key in settings.keys or not settings.keys}
        cases = settings.cases[: request.repetitions]
        jobs = {f"{case.name}_{key or 'default'}": (settings, case, key) for case in cases for key in ("", *varied)}
        parts = finished_parts(
            request.work,
            request.client,
            jobs,
            case_part,
            lambda done: request.progress("settings on cases", done, len(jobs)),
        )
        study = Study(
            cases=cases,
            values=varied,
            factors=settings.factors,
            answers={
                case.name: {key: parts[f"{case.name}_{key or 'default'}"]["answers"] for key in ("", *varied)}
                for case in cases
            },
        )
        used = versions_of(parts.values())
        record = {"settings": asdict(settings), "values": varied, "answers": study.answers, "versions": used}
        return CampaignResult(
            files={PAGE: sensitivity_page(study, used), FIGURES: json_text(record)},
            record=record,
            summary=sensitivity_summary(study),
        )
