"""Campaigns over the cases of a blind check: what the checks of single effects, crowds and rounded nulls share."""

from __future__ import annotations

import json
from abc import abstractmethod
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.validation.blind.make_case import MakeSettings
    from flexros.validation.blind.plan import Case
    from flexros.validation.blind.score.answer import Answer
    from flexros.validation.campaigns.base import CampaignRequest
    from flexros.validation.campaigns.blind.settings import BlindSettings
    from flexros.validation.campaigns.crowds.settings import CrowdSettings
    from flexros.validation.campaigns.quantized_nulls.settings import QuantizedNullsSettings

S = TypeVar("S", "BlindSettings", "CrowdSettings", "QuantizedNullsSettings")


@dataclass(frozen=True, eq=False)
class ScoredCases:
    """Cases of a blind check, diagnosed and scored.

    Attributes:
        answers: The cases as scored.
        failures: What stopped a diagnosis, by name of the case.
        planned: Number of cases of the whole plan.
        used: Versions of packages and code.
        controls: Some of the cases once more under other conditions, by name of the case.
    """

    answers: Sequence[Answer]
    failures: Mapping[str, str]
    planned: int
    used: Mapping[str, str]
    controls: Mapping[str, Answer] = field(default_factory=dict)


@dataclass(frozen=True)
class Written:
    """What a campaign says of its cases.

    Attributes:
        page: The page of results.
        summary: The result in sentences, one per line of the terminal.
        pictures: Pictures of the page, SVG by name.
    """

    page: str
    summary: tuple[str, ...]
    pictures: Mapping[str, str] = field(default_factory=dict)


class AbstractBlindCampaign(AbstractCampaign, Generic[S]):
    """The cases of a plan, or the first part of them, each made, diagnosed without its truth, and scored.

    `--repetitions N` works on the first N cases of the plan, which are a fair sample of it; a larger N goes on.

    Args:
        settings: Seed, plan and lengths.
    """

    cases: ClassVar[str]
    """What the cases are called while they are worked on."""

    def __init__(self, settings: S) -> None:
        self.settings: S = settings

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        claim_folder(request.work, asdict(self.settings))
        return self.result(self.scored(request))

    def scored(self, request: CampaignRequest) -> ScoredCases:
        """Diagnose and score the cases, or those that are left of them."""
        plan, made = self.plan(), self.make_settings()
        chosen = plan[: request.repetitions or len(plan)]
        parts = case_parts(request, {case.name: (made, case) for case in chosen}, self.cases)
        failures = {name: part["failure"] for name, part in parts.items() if part["failure"]}
        return ScoredCases(answers_of(parts), failures, len(plan), versions_of(parts.values()))

    def plan(self) -> tuple[Case, ...]:
        """List all cases, shuffled so that every beginning of the list is a fair sample."""
        from flexros.validation.blind.plan import plan_cases

        settings = self.settings
        return plan_cases(settings.plan, settings.seed, settings.stream)

    def make_settings(self) -> MakeSettings:
        """Return how the logs of a case are made."""
        from flexros.validation.blind.make_case import MakeSettings

        settings = self.settings
        return MakeSettings(settings.seed, settings.stream, settings.durations)

    def result(self, found: ScoredCases) -> CampaignResult:
        """Return page, pictures, figures and summary of the cases."""
        from flexros.json_text import json_text

        figures: dict[str, Any] = {
            "settings": json.loads(json.dumps(asdict(self.settings))),
            "planned": found.planned,
            "scores": self.scores(found.answers),
            "cases": [self.row(one) for one in found.answers],
            "failures": found.failures,
            "versions": found.used,
        }
        if found.controls:
            figures["controls"] = [self.row(one) for one in found.controls.values()]
        written = self.written(found)
        files = {f"{self.name}.md": written.page, f"data/{self.name}.json": json_text(figures)}
        files |= {f"figures/{self.name}_{name}.svg": text for name, text in written.pictures.items()}
        return CampaignResult(files, figures, written.summary)

    @abstractmethod
    def scores(self, answers: Sequence[Answer]) -> dict[str, Any]:
        """Count hits and misses, for JSON."""

    @abstractmethod
    def row(self, one: Answer) -> dict[str, Any]:
        """Put truth and answer of a case into a row for JSON."""

    @abstractmethod
    def written(self, found: ScoredCases) -> Written:
        """Write page, summary and pictures."""


def case_parts(
    request: CampaignRequest, jobs: Mapping[str, tuple[MakeSettings, Case]], what: str
) -> dict[str, dict[str, Any]]:
    """Make and diagnose cases, those that have no part yet.

    Args:
        request: Where parts are kept, and who computes.
        jobs: How a case is made, and the case, by the name of its part.
        what: What they are called in the progress.
    """
    from flexros.validation.campaigns.blind.case_part import case_part

    return finished_parts(
        request.work, request.client, jobs, case_part, lambda done: request.progress(what, done, len(jobs))
    )


def answers_of(parts: Mapping[str, Mapping[str, Any]]) -> list[Answer]:
    """Open the truths of parts and check their seals; a case that cannot be drawn has none."""
    from flexros.validation.campaigns.blind.case_part import answer_of

    return [answer_of(name, part) for name, part in parts.items() if part["truth"] is not None]
