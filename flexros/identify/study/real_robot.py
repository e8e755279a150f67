"""The "real" robot of the study: what the gray-box model does not know, and the experiment on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.config.scenario import PlantSettings, Scenario, load_scenario
from flexros.identify.design.experiment_design import DesignSettings, design_experiment
from flexros.identify.frf.positions import estimate_responses
from flexros.identify.plan import plan_of_scenario
from flexros.identify.slow_motion import SlowSine
from flexros.robot.robot import load_robot
from flexros.simulate.closed_loop import closed_loop
from flexros.simulate.experiment import Experiment

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot

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
        gear = robot.arm_names[robot.chain.geared[motor]]
        name = robot.joint_names[motor]
        if np.isfinite(limit):
            effects.append(f"nonlinear_stiffness@{gear}:relative={HARDENING:g},knee_torque={KNEE * limit:g}")
            effects.append(f"coulomb_friction@{name}:level={FRICTION * limit:g}")
            effects.append(f"torque_ripple@{name}:amplitude={RIPPLE * limit:g},order={RIPPLE_ORDER:g}")
    return tuple(effects)


def study_scenario(base: str, positions: int, blocks: int, seed: int, candidates: int = 2000) -> Scenario:
    """Put the experiment of the study together.

    Args:
        base: Scenario whose robot, excitation and controller are taken, e.g. "identify_six_axis".
        positions: Number of positions, chosen by the D-optimal design.
        blocks: Blocks of experiments in each position.
        seed: Seed of phases, noise and candidate positions.
        candidates: Number of candidate positions.

    Returns:
        The scenario, with the effects of the real robot in the plant.

    Raises:
        InputError: The scenario is not known or describes no identification.
    """
    scenario = load_scenario(base)
    robot = load_robot(scenario.robot)
    specification = scenario.identification
    assert specification is not None
    slow = SlowSine(kind="sine", speed=tuple(SLOW * specification.excitation.sizes(robot.n_motors)))
    specification = specification.model_copy(update={"blocks": blocks, "slow_motion": slow})
    names = unknowns(robot)
    design = design_experiment(
        robot,
        names,
        specification,
        scenario.controller,
        scenario.sample_time or robot.sample_time,
        DesignSettings(positions=positions, candidates=candidates, seed=seed),
    )
    gears = tuple(tuple(float(f"{angle:.6g}") for angle in row) for row in design.positions)
    return scenario.model_copy(
        update={
            "identification": specification.model_copy(update={"positions": gears}),
            "plant": PlantSettings(effects=unmodelled_effects(robot)),
            "seed": seed,
        }
    )


def unknowns(robot: Robot) -> tuple[str, ...]:
    """Name what is identified: what the robot file lists, else all springs and dampers that are not zero."""
    return robot.spec.unknown_parameters or tuple(
        name
        for name, parameter in robot.parameters.items()
        if name.endswith((".stiffness", ".damping")) and parameter.value > 0
    )


def measured_responses(
    scenario: Scenario, progress: Callable[[int], None] | None = None
) -> tuple[FrequencyResponse, ...]:
    """Run the experiment in this process and estimate the frequency responses.

    Args:
        scenario: The experiment.
        progress: Called with the number of samples done, now and then.

    Returns:
        One response per position.

    Raises:
        InputError: The experiment is not possible within the limits of the robot.
        RunError: The robot became unstable.
    """
    log = closed_loop(Experiment.prepare(scenario), progress)
    return estimate_responses(log, plan_of_scenario(scenario))
