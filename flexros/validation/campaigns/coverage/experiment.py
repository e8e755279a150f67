"""The experiment that is repeated, and the frequency responses of repetitions side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.design.experiment_design import DesignSettings, design_experiment
from flexros.identify.frf.positions import estimate_responses
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.robot.robot import load_robot
from flexros.scenario.batch import batch
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification import designed_scenario, unknown_names
from flexros.scenario.identification_plan import plan_of_scenario

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.scenario.batch import RunRecord
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.coverage.settings import CoverageSettings, RepetitionGroup


def repeated_scenario(
    template: Scenario, settings: CoverageSettings, progress: Callable[[str, int, int], None] | None = None
) -> Scenario:
    """Choose the positions as `flexros identify robot` does.

    Args:
        template: Robot, excitation and controller.
        settings: Number of positions and of candidates.
        progress: Called with the current step, the amount done and the amount in all.

    Returns:
        The experiment of one repetition.

    Raises:
        InputError: The experiment is not possible.
    """
    assert template.identification is not None
    robot = load_robot(template.robot)
    design = design_experiment(
        robot,
        unknown_names(robot),
        template.identification,
        template.controller,
        template.sample_time or robot.sample_time,
        DesignSettings(settings.positions, settings.candidates, seed=settings.design_seed),
        progress=progress,
    )
    return designed_scenario(template, robot, design)[0]


def group_responses(scenario: Scenario, group: RepetitionGroup) -> list[tuple[FrequencyResponse, ...]]:
    """Simulate the experiment for all repetitions of a group and estimate their responses.

    Positions are simulated one after the other, each from home with all other positions left out, so that memory does
    not grow with their number; lines, phases and amplitudes are those of the whole experiment.

    Args:
        scenario: The experiment.
        group: Phases and noise.

    Returns:
        For every repetition one response per position.
    """
    assert scenario.identification is not None
    blocks = scenario.identification.blocks_per_position
    by_position = [
        _position_responses(_of_position(scenario, place, group.phase_seed), group.noise_seeds)
        for place in range(len(blocks))
        if blocks[place]
    ]
    return [tuple(row) for row in zip(*by_position, strict=True)]


def _of_position(scenario: Scenario, place: int, seed: int) -> Scenario:
    """Leave out all positions but one."""
    assert scenario.identification is not None
    blocks = [number * (k == place) for k, number in enumerate(scenario.identification.blocks_per_position)]
    return scenario.with_values({"identification.blocks": blocks, "seed": seed, "noise": True})


def _position_responses(scenario: Scenario, seeds: tuple[int, ...]) -> list[FrequencyResponse]:
    """Simulate one position with several noises."""
    experiment, plan = Experiment.prepare(scenario), plan_of_scenario(scenario)
    names = experiment.plant.joint_names

    def response(record: RunRecord) -> FrequencyResponse:
        stamp = stamps_ns(len(record.encoder), experiment.sample_time)
        log = Log(JointSeries(stamp, names, position=record.encoder), JointSeries(stamp, names, effort=record.command))
        return estimate_responses(log, plan, robot=experiment.nominal, start_stamp=int(stamp[0]))[0]

    return batch(experiment, response, seeds=seeds, threads=1)
