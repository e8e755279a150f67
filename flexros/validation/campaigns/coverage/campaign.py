"""Campaign: do the 95 % intervals of an identification cover the truth?"""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.atomic_file import write_whole
from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.coverage.settings import CoverageSettings
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "identification_coverage.md", "data/identification_coverage.json"


class Coverage(AbstractCampaign):
    """Repeated identifications of a robot that equals its model.

    Args:
        settings: What is repeated.
    """

    name: ClassVar[str] = "coverage"
    question: ClassVar[str] = "Do the 95 % intervals of an identification cover the truth?"

    def __init__(self, settings: CoverageSettings | None = None) -> None:
        self._settings = settings or CoverageSettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.robot.robot import load_robot
        from flexros.scenario.identification import unknown_names
        from flexros.validation.campaigns.coverage.estimates import group_estimates

        settings = replace(self._settings, repetitions=request.repetitions or self._settings.repetitions)
        scenario = _experiment(settings, request)
        names = unknown_names(load_robot(scenario.robot))
        jobs = {
            f"{group.name}_of_{len(group.noise_seeds)}": (scenario, names, settings, group) for group in settings.groups
        }
        parts = finished_parts(
            request.work,
            request.client,
            jobs,
            group_estimates,
            lambda done: request.progress("groups of repetitions", done, len(jobs)),
        )
        return _result(list(parts.values()), scenario, names, settings)


def _result(
    parts: list[dict[str, Any]], scenario: Scenario, names: tuple[str, ...], settings: CoverageSettings
) -> CampaignResult:
    """Count over all groups and write the page."""
    from flexros.robot.robot import load_robot
    from flexros.scenario.identification_plan import plan_of_scenario
    from flexros.validation.campaigns.coverage.estimates import WAYS
    from flexros.validation.campaigns.coverage.figures import way_coverage
    from flexros.validation.campaigns.coverage.page import coverage_page, coverage_summary

    robot = load_robot(scenario.robot)
    ways = [
        way_coverage(way.name, _by_phases([part[way.name] for part in parts], settings), robot, names) for way in WAYS
    ]
    duration, used = plan_of_scenario(scenario).duration, versions_of(parts)
    record = {
        "settings": asdict(settings),
        "robot_time_s": duration,
        "scenario": scenario.settings(),
        "ways": {way.name: asdict(way) for way in ways},
        "versions": used,
    }
    return CampaignResult(
        files={PAGE: coverage_page(ways, settings, duration, used), FIGURES: json.dumps(record, indent=1) + "\n"},
        record=record,
        summary=coverage_summary(ways, duration),
    )


def _by_phases(groups: list[list[Any]], settings: CoverageSettings) -> list[list[Any]]:
    """Join the groups that have the same phases."""
    step = settings.groups_per_phase
    return [[row for group in groups[k : k + step] for row in group] for k in range(0, len(groups), step)]


def _experiment(settings: CoverageSettings, request: CampaignRequest) -> Scenario:
    """Design the experiment, or take it from the folder; make sure that the folder belongs to these settings."""
    from flexros.scenario.identification import scenario_yaml
    from flexros.scenario.scenario import load_scenario
    from flexros.validation.campaigns.coverage.experiment import repeated_scenario

    template = load_scenario(settings.scenario)
    known: dict[str, Any] = {**asdict(settings), "template": template.settings()}
    known.pop("repetitions")  # more of them add parts
    claim_folder(request.work, known)
    file = request.work / "experiment.yaml"
    if not file.exists():
        write_whole(file, scenario_yaml(repeated_scenario(template, settings, request.progress)))
    return load_scenario(file)
