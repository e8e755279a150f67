"""Campaign of nulls with rounded encoders: is a robot without deviation called one without gap?"""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.validation.campaigns.blind_campaign import AbstractBlindCampaign, Written, answers_of, case_parts
from flexros.validation.campaigns.parts import versions_of
from flexros.validation.campaigns.quantized_nulls.settings import QuantizedNullsSettings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.validation.blind.make_case import MakeSettings
    from flexros.validation.blind.plan import Case
    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.base import CampaignRequest
    from flexros.validation.campaigns.blind_campaign import ScoredCases


class QuantizedNulls(AbstractBlindCampaign[QuantizedNullsSettings]):
    """Cases of the blind check without deviation, whose encoders round; see `AbstractBlindCampaign`."""

    name: ClassVar[str] = "quantized_nulls"
    question: ClassVar[str] = "Is a robot without deviation, whose encoders round their positions, called `no_gap`?"
    cases: ClassVar[str] = "nulls"

    def __init__(self, settings: QuantizedNullsSettings | None = None) -> None:
        super().__init__(settings or QuantizedNullsSettings())

    def plan(self) -> tuple[Case, ...]:
        """List all cases; nominal models are exact, or wrong as the settings say."""
        wrong = self.settings.wrong
        return tuple(one if one.nuisance == "exact" else replace(one, nuisance=wrong) for one in super().plan())

    def make_settings(self) -> MakeSettings:
        """Return how the logs of a case are made: with encoders that round."""
        return replace(super().make_settings(), encoder_steps=self.settings.encoder_steps)

    def scored(self, request: CampaignRequest) -> ScoredCases:
        """Diagnose and score the cases; false alarms once more without rounding, all else being equal."""
        from flexros.validation.campaigns.quantized_nulls.page import alarmed

        found, plain = super().scored(request), super().make_settings()
        alarms = {one.truth.name for one in found.answers if alarmed(one)}
        jobs = {f"{case.name}_smooth": (plain, case) for case in self.plan() if case.name in alarms}
        if not jobs:
            return found
        parts = case_parts(request, jobs, "false alarms without rounding")
        used = {**found.used, "commit without rounding": versions_of(parts.values())["commit"]}
        return replace(found, controls={one.truth.name: one for one in answers_of(parts)}, used=used)

    def scores(self, answers: Sequence[Answer]) -> dict[str, Any]:
        """Count false alarms, also by group; see `AbstractBlindCampaign.scores`."""
        from flexros.validation.campaigns.quantized_nulls.page import false_alarms, groups

        return {name: asdict(false_alarms(some)) for name, some in {"all": answers, **groups(answers)}.items()}

    def row(self, one: Answer) -> dict[str, Any]:
        """Put conditions and answer of a case into a row; see `AbstractBlindCampaign.row`."""
        diagnosis = one.diagnosis
        return {
            **one.truth.model_dump(
                mode="json", exclude={"salt", "robot_sha256", "kind", "size", "deviations", "gains"}
            ),
            "verdict": None if diagnosis is None else diagnosis.verdict,
            "gap": None if diagnosis is None else diagnosis.gap.before,
            "noise_floor": None if diagnosis is None else diagnosis.gap.noise_floor,
            "causes": [[cause.effect, cause.location, round(cause.probability, 4)] for cause in one.causes],
            "seconds": one.seconds,
        }

    def written(self, found: ScoredCases) -> Written:
        """Write page and summary; see `AbstractBlindCampaign.written`."""
        from flexros.validation.campaigns.quantized_nulls.page import nulls_page, nulls_summary

        page = nulls_page(found, self.settings)
        return Written(page, nulls_summary(found.answers, found.planned))
