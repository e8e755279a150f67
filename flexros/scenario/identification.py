"""The scenario of an identification experiment: from a template to chosen positions."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.identify.design.amplitude import amplitude_room
from flexros.identify.design.decay import decays_at
from flexros.identify.design.default_controller import default_controller
from flexros.identify.design.experiment_design import SETTLED
from flexros.identify.design.moves import move_factor
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import Scenario, load_scenario, scenario_names

if TYPE_CHECKING:
    from flexros.identify.design.experiment_design import ExperimentDesign
    from flexros.robot import Robot

LONGEST = 1800.0
"""Longest experiment to which transient periods are added [s] (chosen)."""
_DIGITS = 4
"""Decimals of gear coordinates in a scenario (chosen)."""


def unknown_names(robot: Robot) -> tuple[str, ...]:
    """Name the parameters to identify: those that the robot file lists, else all springs and dampers above zero."""
    if robot.spec.unknown_parameters:
        return robot.spec.unknown_parameters
    ends = (".stiffness", ".damping")
    names = tuple(name for name, one in robot.parameters.items() if name.endswith(ends) and one.value > 0)
    if not names:
        raise InputError(
            f"robot {robot.name} has neither springs nor dampers, so nothing is to be identified by frequency "
            "responses; name unknown parameters with --unknown, or use flexros identify rigid"
        )
    return names


def template_scenario(robot: Robot, reference: str, given: str = "") -> Scenario:
    """Find the scenario that says how to experiment with a robot: excitation, controller, feedforward.

    Args:
        robot: The robot.
        reference: Shipped name or file of the robot.
        given: Scenario to take, shipped or a file; default: the shipped one for the robot, else a controller is chosen
            for it and all else is left at its defaults.

    Returns:
        A scenario with identification; its positions are still to be chosen.

    Raises:
        InputError: The scenario has no identification.
    """
    shipped = f"identify_{robot.name}"
    if given or shipped in scenario_names():
        scenario = load_scenario(given or shipped)
        if scenario.identification is None:
            raise InputError(f"scenario {scenario.name} has no key identification, so it is no experiment; add the key")
        return scenario.with_values({"robot": reference})
    flexible = bool(robot.chain.flexible_motors)
    settings = {
        "name": shipped,
        "description": "Identification experiment with a controller chosen by FlexROS.",
        "robot": reference,
        "identification": {"positions": [robot.home[list(robot.chain.geared)].tolist()]},
        "feedforward": {"method": "flexible_joint" if flexible else "rigid"},
        "controller": {"kind": "pid", **default_controller(robot, robot.sample_time).model_dump(mode="json")},
    }
    return validate(Scenario, settings, shipped)


def designed_scenario(
    template: Scenario, robot: Robot, design: ExperimentDesign, longest: float = LONGEST
) -> tuple[Scenario, float]:
    """Put the chosen positions into a scenario.

    Amplitude and speed of the moves are lowered where the torque limits leave no room for them, and transient periods
    are added where the loop settles slowly and time is left.

    Args:
        template: The experiment in each position.
        robot: The robot with its nominal values.
        design: The positions.
        longest: Longest experiment to which transient periods are added [s].

    Returns:
        The scenario, and the factor by which amplitudes were lowered, 1 where they were not.
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
    """Lower acceleration and speed of the moves as far as the torque limits ask for."""
    specification = template.identification
    assert specification is not None
    allowed = specification.limits.torque_share * template.controller.command_limits(robot)
    start = robot.home if template.start is None else np.array(template.start)
    factor = move_factor(robot, start[list(robot.chain.geared)], design.positions, specification.move, allowed)
    if factor == 1.0:
        return {}
    return {
        "identification.move.acceleration": _scaled(specification.move.acceleration, factor),
        "identification.move.speed": _scaled(specification.move.speed, float(np.sqrt(factor))),
    }


def _scaled(values: float | tuple[float, ...], factor: float) -> float | list[float]:
    """Multiply one number or one per motor, with three digits left."""
    scaled = [float(f"{factor * value:.2e}") for value in np.atleast_1d(values)]
    return scaled if len(scaled) > 1 else scaled[0]


def _transient_periods(scenario: Scenario, robot: Robot, design: ExperimentDesign, longest: float) -> int:
    """Give the periods after which the loop has settled in every position, as far as time allows."""
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
            f"the controller of scenario {scenario.name} does not hold robot {robot.name} steady at the gear positions "
            f"{where}; lower its gains, or narrow the ranges"
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
    """Write a scenario as the text of a file.

    Args:
        scenario: The scenario.

    Returns:
        The text; lists of numbers take one line each.
    """
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
