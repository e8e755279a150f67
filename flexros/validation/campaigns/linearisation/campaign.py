"""Campaign: feedback linearisation or feedforward?"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, ClassVar

from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.linearisation.settings import LinearisationSettings
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "linearisation_study.md", "data/linearisation_study.json"


class Linearisation(AbstractCampaign):
    """Feedback linearisation against feedforward (Moberg 2007, sections 5.6 and 6.2).

    `--repetitions N` draws N plants for each random model error, and no more noise seeds than that.

    Args:
        settings: Robots, laws, conditions and repetitions.
    """

    name: ClassVar[str] = "linearisation"
    question: ClassVar[str] = (
        "Does the nonlinear model belong into the feedback loop or into the feedforward, when model, delay, noise and "
        "disturbances are not ideal?"
    )

    def __init__(self, settings: LinearisationSettings | None = None) -> None:
        self._settings = settings or LinearisationSettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from dataclasses import replace

        from flexros.validation.campaigns.linearisation.conclusions import answer
        from flexros.validation.campaigns.linearisation.figures import COLUMNS, Results, record_of, record_text
        from flexros.validation.campaigns.linearisation.law_part import law_part
        from flexros.validation.campaigns.linearisation.page import page
        from flexros.validation.campaigns.linearisation.pictures import pictures
        from flexros.validation.campaigns.linearisation.robustness import robustness_part

        settings = self._settings
        if request.repetitions is not None:
            fewer = min(settings.repetitions, request.repetitions)
            settings = replace(settings, draws=request.repetitions, repetitions=fewer)
        claim_folder(request.work, asdict(settings))
        keys = [(robot, how, law) for robot in settings.robots for how in settings.tunings for law in settings.laws]
        jobs = {
            f"{robot.name}_{how}_{law}".replace(" ", "_").replace("+", "and"): (settings, robot, law, how)
            for robot, how, law in keys
        }
        found = finished_parts(
            request.work,
            request.client,
            jobs,
            law_part,
            lambda done: request.progress("laws on robots", done, len(jobs)),
        )
        robust = finished_parts(
            request.work,
            request.client,
            {f"{robot.name}_sensitivity": (settings, robot) for robot in settings.robots},
            robustness_part,
            lambda done: request.progress("margins of the robots", done, len(settings.robots)),
        )
        by_key = {(robot.name, how, law): part for (robot, how, law), part in zip(keys, found.values(), strict=True)}
        results = Results(settings, by_key, {name.removesuffix("_sensitivity"): part for name, part in robust.items()})
        used = versions_of(found.values())
        record = {
            "settings": asdict(settings),
            "columns": COLUMNS,
            "results": record_of(results),
            "robustness": results.robustness,
            "versions": used,
        }
        files = {PAGE: page(results, used), FIGURES: record_text(record)}
        files |= {f"figures/linearisation_{name}.svg": drawing.svg() for name, drawing in pictures(results).items()}
        return CampaignResult(files=files, record=record, summary=answer(results))
