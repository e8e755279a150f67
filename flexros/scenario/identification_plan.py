"""The plan of the identification experiment of a scenario, or of the scenario of a log."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.config.settings import validate
from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError, source_named
from flexros.identify.experiment.plan import ExperimentPlan
from flexros.scenario.scenario import Scenario

if TYPE_CHECKING:
    from flexros.logs.time_series import Log


def plan_of_scenario(scenario: Scenario) -> ExperimentPlan:
    """Build the plan of a scenario with the key `identification`.

    Raises:
        InputError: The key is missing, or the plan is not possible.
    """
    source = f"scenario {scenario.name}"
    if scenario.identification is None:
        raise InputError(f"{source} has no key identification; add it")
    patched = load_patched(scenario.robot).with_values(scenario.model.values, f"{source}, key model.values")
    robot = patched.model.robot
    with source_named(source):
        start = robot.home if scenario.start is None else robot.check_arm(scenario.start)
        sample_time = robot.sample_time if scenario.sample_time is None else scenario.sample_time
        gears = start[list(robot.gear_rows)]
        return ExperimentPlan.build(scenario.identification, robot, sample_time, scenario.seed, gears)


def plan_of_log(log: Log) -> ExperimentPlan:
    """Rebuild the plan of a log from the scenario in its provenance.

    Raises:
        InputError: The log has no scenario, or one without identification.
    """
    settings = log.provenance.get("scenario")
    if not isinstance(settings, dict) or settings.get("identification") is None:
        what = "holds no scenario" if not isinstance(settings, dict) else "is of a scenario without identification"
        raise InputError(
            f"the provenance of the log {what}, so positions and periods of the experiment are unknown; give the "
            "scenario of the experiment, or the log of an identification"
        )
    return plan_of_scenario(validate(Scenario, settings, "provenance of the log, key scenario"))
