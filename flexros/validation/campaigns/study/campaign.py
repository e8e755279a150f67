"""Campaign: how do estimators fare on a robot that the model does not fully know?"""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.atomic_file import write_whole
from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.parts import claim_folder, finished_parts
from flexros.validation.campaigns.study.settings import StudySettings

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.base import CampaignRequest


class PaperStudy(AbstractCampaign):
    """The study of Paper A of Moberg (2007) on a simulated robot with effects outside the model.

    Args:
        settings: What is measured and how often it is fitted.
    """

    name: ClassVar[str] = "study"
    question: ClassVar[str] = "How do six estimators fare from random starts on a robot the model does not fully know?"

    def __init__(self, settings: StudySettings | None = None) -> None:
        self._settings = settings or StudySettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.identify.graybox.problem import graybox_problem
        from flexros.robot.robot import load_robot
        from flexros.scenario.identification import unknown_names
        from flexros.validation.campaigns.study.jobs import fitted_rows, study_jobs, study_of
        from flexros.validation.campaigns.study.page import numbers, study_files, study_summary

        settings = replace(self._settings, starts=request.repetitions or self._settings.starts)
        claim_folder(request.work, {**asdict(settings), "starts": None, "redrawn": None})  # more of them add parts
        scenario = _experiment(settings, request)
        robot = load_robot(scenario.robot)
        problem = graybox_problem(robot, _responses(scenario, request), unknown_names(robot))
        jobs: dict[str, tuple[Any, ...]] = dict(study_jobs(problem, settings))
        parts = finished_parts(
            request.work,
            request.client,
            jobs,
            fitted_rows,
            lambda done: request.progress("groups of fits", done, len(jobs)),
            shared=(problem,),
        )
        study = study_of(problem, parts, settings)
        return CampaignResult(study_files(study, scenario), numbers(study, scenario), study_summary(study))


def _experiment(settings: StudySettings, request: CampaignRequest) -> Scenario:
    """Design the experiment, or take it from the folder."""
    from flexros.scenario.identification import scenario_yaml
    from flexros.scenario.scenario import load_scenario
    from flexros.validation.campaigns.study.real_robot import study_scenario

    file = request.work / "experiment.yaml"
    if not file.exists():
        write_whole(file, scenario_yaml(study_scenario(settings, request.progress)))
    return load_scenario(file)


def _responses(scenario: Scenario, request: CampaignRequest) -> tuple[FrequencyResponse, ...]:
    """Measure the real robot, or take the responses from the folder."""
    from flexros.identify.frf.files.netcdf import load_responses, save_responses
    from flexros.validation.campaigns.study.real_robot import measured_responses

    file = request.work / "responses.nc"
    if not file.exists():
        save_responses(measured_responses(scenario, request.progress), file)
    return load_responses(file)
