"""Design of an identification experiment: template, chosen positions, scenario file."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.atomic_file import write_result
from flexros.config.settings import validate
from flexros.errors import InputError, argument_named, unknown_name
from flexros.identify.design.amplitude import amplitude_room
from flexros.identify.design.decay import decays_at
from flexros.identify.design.default_controller import default_controller
from flexros.identify.design.experiment_design import (
    SETTLED,
    DesignSettings,
    default_positions,
    design_experiment,
)
from flexros.identify.design.moves import move_factor
from flexros.identify.design.real_robot import stand_in_values
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import Scenario, load_scenario, scenario_names

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike

    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.robot import Robot

LONGEST = 1800.0
"""Longest experiment to which transient periods are added [s] (chosen)."""
_DIGITS = 4
"""Decimals of gear coordinates in a scenario (chosen)."""
_LISTED = "(others are named alike, e.g. body_1.mass, body_2.center_of_mass.x, motor_1.inertia)"


def unknown_names(robot: Robot, given: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of the parameters to identify.

    Args:
        robot: The robot.
        given: Names; default: those listed in the robot file, else all springs and dampers above zero.

    Returns:
        The names without duplicates.

    Raises:
        InputError: A name is not a parameter of the robot, or there is none.
    """
    for name in given:
        if name not in robot.parameters:
            with argument_named("unknown"):
                raise unknown_name(f"parameter of robot {robot.name}", name, robot.parameters, other=_LISTED)
    if given or robot.spec.unknown_parameters:
        return tuple(dict.fromkeys(given)) or robot.spec.unknown_parameters
    ends = (".stiffness", ".damping")
    names = tuple(name for name, entry in robot.parameters.items() if name.endswith(ends) and entry.value > 0)
    if not names:
        raise InputError(
            f"robot {robot.name} has neither springs nor dampers, so nothing is to be identified by frequency "
            "responses; name the unknown parameters, or identify the rigid model",
            "unknown",
        )
    return names


def template_scenario(robot: Robot, reference: str, given: str = "") -> Scenario:
    """Return the scenario of an identification experiment: excitation, controller, feedforward.

    Args:
        robot: The robot.
        reference: Built-in name or file of the robot.
        given: Built-in name or file of a scenario; default: the built-in one for the robot, else a scenario with a
            controller designed for the robot and defaults otherwise.

    Returns:
        A scenario with identification, whose positions are to be chosen.

    Raises:
        InputError: The scenario has no identification.
    """
    built_in = f"identify_{robot.name}"
    if given or built_in in scenario_names():
        scenario = load_scenario(given or built_in)
        if scenario.identification is None:
            raise InputError(f"scenario {scenario.name} has no key identification; add it")
        return scenario.with_values({"robot": reference})
    flexible = bool(robot.flexible_motors)
    settings = {
        "name": built_in,
        "description": "Identification experiment with a controller chosen by FlexROS.",
        "robot": reference,
        "identification": {"positions": [robot.home[list(robot.gear_rows)].tolist()]},
        "feedforward": {"method": "flexible_joint" if flexible else "rigid"},
        "controller": {"kind": "pid", **default_controller(robot, robot.sample_time).model_dump(mode="json")},
    }
    return validate(Scenario, settings, built_in)


def with_real_robot(template: Scenario, nominal: Robot, real: Robot) -> Scenario:
    """Set the plant of an experiment to another robot that represents the real one.

    Args:
        template: The experiment.
        nominal: The nominal robot.
        real: The stand-in; it may differ in parameters of the equations of motion.

    Returns:
        The experiment with the values of the plant; values of the template take precedence.

    Raises:
        InputError: The robots differ in more than parameters.
    """
    with argument_named("real"):
        values = {**stand_in_values(nominal, real), **template.plant.values}
        changed = {"plant": {**template.plant.model_dump(mode="json"), "values": values}}
        return template.with_values(changed, f"robot {real.name}")


@dataclass(frozen=True, eq=False)
class DesignedExperiment:
    """A designed identification experiment.

    Attributes:
        design: The positions and their candidates.
        scenario: The experiment in these positions.
        amplitude_factor: Factor on the amplitudes of the template, below 1 if torque limits require it.
        duration: Robot time [s].
    """

    design: ExperimentDesign
    scenario: Scenario
    amplitude_factor: float
    duration: float


def design_identification(
    robot: Robot,
    names: Sequence[str],
    template: Scenario,
    file: Path,
    *,
    settings: DesignSettings | None = None,
    ranges: ArrayLike | None = None,
    longest: float = LONGEST,
    progress: Callable[[str, int, int], None] | None = None,
) -> DesignedExperiment:
    """Choose the positions of an experiment and write its scenario.

    Args:
        robot: The nominal robot.
        names: Unknown parameters.
        template: Excitation and controller, see `template_scenario`.
        file: File of the scenario; an existing one is replaced.
        settings: Number of positions and candidates; default: `default_positions` with the seed of the template.
        ranges: Smallest and largest coordinate of each gear [rad or m], shape (M, 2); see `candidate_positions`.
        longest: Largest robot time with added transient periods [s].
        progress: Called with the current step, the amount done and the total.

    Returns:
        The experiment, with its scenario as read back from the file.

    Raises:
        InputError: Invalid template, ranges or names, or the file cannot be written.
    """
    if template.identification is None:
        raise InputError(f"scenario {template.name} has no key identification; add it")
    settings = settings or DesignSettings(default_positions(len(names)), seed=template.seed)
    sample_time = robot.sample_time if template.sample_time is None else template.sample_time
    design = design_experiment(
        robot, names, template.identification, template.controller, sample_time, settings, ranges, progress
    )
    scenario, factor = designed_scenario(template, robot, design, longest)
    with argument_named("out"):
        write_result(file, scenario_yaml(scenario), "scenario")
    scenario = load_scenario(file)
    return DesignedExperiment(design, scenario, factor, plan_of_scenario(scenario).duration)


def designed_scenario(
    template: Scenario, robot: Robot, design: ExperimentDesign, longest: float = LONGEST
) -> tuple[Scenario, float]:
    """Return the scenario with the chosen positions.

    Amplitude and speed of the moves are reduced to the torque limits. Transient periods are added where the loop
    settles slowly, as far as time allows.

    Args:
        template: The experiment in each position.
        robot: The robot with its nominal values.
        design: The positions.
        longest: Longest experiment to which transient periods are added [s].

    Returns:
        The scenario, and the factor on the amplitudes, at most 1.
    """
    assert template.identification is not None
    blocks = max(template.identification.blocks_per_position)
    motors = design.candidates.motor_positions[design.chosen]
    share = template.identification.limits.torque_share
    room = amplitude_room(robot, motors, design.conditions, template.controller, design.sample_time, share)
    factor = min(1.0, room)
    changes: dict[str, Any] = {
        "description": _description(robot, design),
        "identification.positions": np.round(design.positions, _DIGITS).tolist(),
        "identification.blocks": blocks if np.all(design.counts == 1) else (blocks * design.counts).tolist(),
    }
    if factor < 1.0:
        amplitude = _scaled(template.identification.excitation.amplitude, factor)
        changes["identification.excitation.amplitude"] = amplitude
    changes |= _move_changes(template, robot, design)
    scenario = template.with_values(changes, "design")
    periods = _transient_periods(scenario, robot, design, longest)
    return scenario.with_values({"identification.transient_periods": periods}, "design"), factor


def _move_changes(template: Scenario, robot: Robot, design: ExperimentDesign) -> dict[str, Any]:
    """Reduce acceleration and speed of the moves to the torque limits."""
    specification = template.identification
    assert specification is not None
    allowed = specification.limits.torque_share * template.controller.command_limits(robot)
    start = robot.home if template.start is None else np.array(template.start)
    factor = move_factor(robot, start[list(robot.gear_rows)], design.positions, specification.move, allowed)
    if factor == 1.0:
        return {}
    return {
        "identification.move.acceleration": _scaled(specification.move.acceleration, factor),
        "identification.move.speed": _scaled(specification.move.speed, float(np.sqrt(factor))),
    }


def _scaled(values: float | tuple[float, ...], factor: float) -> float | list[float]:
    """Multiply one value or one per motor, rounded to three digits."""
    scaled = [float(f"{factor * value:.2e}") for value in np.atleast_1d(values)]
    return scaled if len(scaled) > 1 else scaled[0]


def _transient_periods(scenario: Scenario, robot: Robot, design: ExperimentDesign, longest: float) -> int:
    """Return the periods after which the loop has settled in every position, as far as time allows."""
    specification = scenario.identification
    assert specification is not None
    own = specification.transient_periods
    if not specification.excitation.periodic:
        return own
    motors = design.candidates.motor_positions[design.chosen]
    decays = decays_at(robot, motors, design.law, design.sample_time)
    if min(decays) <= 0:
        where = np.round(design.positions[int(np.argmin(decays))], 3).tolist()
        raise InputError(
            f"the loop of scenario {scenario.name} with robot {robot.name} is unstable at the gear positions {where}; "
            "lower the gains of the controller, or narrow the ranges"
        )
    period = specification.excitation.record_samples(design.sample_time) * design.sample_time
    experiments = robot.n_motors * sum(specification.blocks_per_position)
    left = longest - plan_of_scenario(scenario).duration
    affordable = int(np.floor(left / (experiments * period)))
    needed = int(np.ceil(SETTLED / (min(decays) * period))) - own
    return own + max(0, min(needed, affordable))


def _description(robot: Robot, design: ExperimentDesign) -> str:
    return (
        f"Identification experiment on {robot.name} in {len(design.chosen)} positions, chosen out of "
        f"{design.origin} for the {len(design.names)} unknown parameters."
    )


def scenario_yaml(scenario: Scenario) -> str:
    """Return the YAML text of a scenario, with each list of numbers on one line."""
    writer, text = YAML(), io.StringIO()
    writer.width = 120
    writer.indent(mapping=2, sequence=4, offset=2)
    writer.dump(_laid_out(scenario.settings()), text)
    return text.getvalue()


def _laid_out(node: Any) -> Any:
    if isinstance(node, dict):
        return CommentedMap((key, _laid_out(value)) for key, value in node.items() if value is not None)
    if isinstance(node, (list, tuple)):
        row = CommentedSeq(_laid_out(value) for value in node)
        if all(isinstance(value, (int, float)) for value in node):
            row.fa.set_flow_style()
        return row
    return node
