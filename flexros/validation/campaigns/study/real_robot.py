"""The "real" robot of the study: what the gray-box model does not know, and the experiment on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.design.experiment_design import DesignSettings, design_experiment
from flexros.identify.experiment.slow_motion import SlowSine
from flexros.identify.frf.positions import estimate_responses
from flexros.robot.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.identification import designed_scenario, template_scenario, unknown_names
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import PlantSettings, Scenario, load_scenario

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot
    from flexros.validation.campaigns.study.settings import StudySettings

HARDENING, KNEE = 0.3, 0.15
"""Gears are this much stiffer beyond a knee at this share of the motor's torque limit (chosen)."""

FRICTION = 0.01
"""Coulomb friction, share of the motor's torque limit (chosen)."""

RIPPLE, RIPPLE_ORDER = 0.002, 12.0
"""Torque ripple, share of the motor's torque limit, and periods per turn of the rotor (chosen)."""

SLOW = 2.0
"""Speed of the slow sine over the rms speed of the multisine, so that motors seldom turn back (chosen)."""


def unmodelled_effects(robot: Robot) -> tuple[str, ...]:
    """List what the real robot has on top of the nominal one: hardening gears, friction and ripple at every motor.

    Args:
        robot: The nominal robot, with torque limits.

    Returns:
        Effects as a scenario states them.
    """
    effects = []
    for motor, limit in enumerate(robot.torque_limits):
        gear = robot.arm_names[robot.gear_rows[motor]]
        name = robot.joint_names[motor]
        if np.isfinite(limit):
            effects.append(f"nonlinear_stiffness@{gear}:relative={HARDENING:g},knee_torque={KNEE * limit:g}")
            effects.append(f"coulomb_friction@{name}:level={FRICTION * limit:g}")
            effects.append(f"torque_ripple@{name}:amplitude={RIPPLE * limit:g},order={RIPPLE_ORDER:g}")
    return tuple(effects)


def study_scenario(settings: StudySettings, progress: Callable[[str, int, int], None] | None = None) -> Scenario:
    """Put the experiment of the study together: positions from the D-optimal design, a real robot in the plant.

    Args:
        settings: What to measure.
        progress: Called with the current step, the amount done and the amount in all.

    Returns:
        The scenario.

    Raises:
        InputError: The scenario is not known, or the experiment is not possible.
    """
    built_in = load_scenario(settings.scenario)
    robot = load_robot(built_in.robot)
    template = template_scenario(robot, built_in.robot, settings.scenario)
    specification = template.identification
    assert specification is not None
    speed = tuple((SLOW * specification.excitation.sizes(robot.n_motors)).tolist())
    moving = specification.model_copy(
        update={"blocks": settings.blocks, "slow_motion": SlowSine(kind="sine", speed=speed)}
    )
    template = template.model_copy(update={"identification": moving, "seed": settings.seed})
    design = design_experiment(
        robot,
        unknown_names(robot),
        moving,
        template.controller,
        template.sample_time or robot.sample_time,
        DesignSettings(settings.positions, settings.candidates, seed=settings.seed),
        progress=progress,
    )
    scenario = designed_scenario(template, robot, design)[0]
    return scenario.model_copy(update={"plant": PlantSettings(effects=unmodelled_effects(robot))})


def measured_responses(
    scenario: Scenario, progress: Callable[[str, int, int], None] | None = None
) -> tuple[FrequencyResponse, ...]:
    """Run the experiment in this process and estimate the frequency responses.

    Args:
        scenario: The experiment.
        progress: Called with what is being done, how much of it is done, and how much there is [samples].

    Returns:
        One response per position.

    Raises:
        InputError: The experiment is not possible within the limits of the robot.
        RunError: The robot became unstable.
    """
    experiment = Experiment.prepare(scenario)

    def report(done: int) -> None:
        if progress is not None:
            progress("samples of the experiment", done, experiment.n_samples)

    return estimate_responses(closed_loop(experiment, report), plan_of_scenario(scenario))
