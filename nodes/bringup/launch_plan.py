"""Nodes and parameters of a launch file, from the arguments of `ros2 launch`."""

from __future__ import annotations

import datetime
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.scenario.scenario import load_scenario, scenario_names
from flexros_nodes.bringup.run_plan import RunPlan, leader_of, new_identity
from flexros_nodes.protocol.parameters import node_parameters

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.scenario.scenario import Scenario
    from flexros_nodes.protocol.parameters import Value


class Argument(NamedTuple):
    """Argument of a launch file: default, description and, if restricted, the allowed values."""

    default: str
    description: str
    choices: tuple[str, ...] = ()


YES_OR_NO = ("true", "false")

COMMON_ARGUMENTS = {
    "realtime": Argument("false", "Pace the loop by the wall clock instead of lock-step", YES_OR_NO),
    "record": Argument("true", "Record the run as a rosbag2 folder", YES_OR_NO),
    "out": Argument("", "New folder for the log; default: bags/SCENARIO_<time>"),
    "params_file": Argument("", "Parameter file for all nodes; it takes precedence over everything else"),
    "remappings": Argument("", "Remappings of names in all nodes, FROM:=TO FROM:=TO ..."),
}
"""Arguments of every launch file, by name."""

RUN_ARGUMENTS = {
    "robot": Argument("", "Robot instead of that of the scenario: built-in name, robot file or patch"),
    "seed": Argument("", "Seed of noise and random disturbances instead of that of the scenario"),
    "effects": Argument("", "Effects in the plant, NAME@LOCATION:parameter=value,... separated by spaces"),
    "begin_at_once": Argument("", "Start an identification at once; false waits for ~/start", ("", *YES_OR_NO)),
    "monitor": Argument("", "Nominal robot of a gap monitor that watches the run; empty for no monitor"),
    "namespace": Argument("", "Namespace of nodes and topics, including the clock"),
}
"""Further arguments of launch files for one robot."""

ROBOTS = Argument("left=circle_dae, right=circle_pd", "Robots side by side, NAMESPACE=SCENARIO, ...")
"""Argument of the launch file for several robots, instead of the previous ones."""


def run_arguments(scenarios: Sequence[str]) -> dict[str, Argument]:
    """Return the arguments of a launch file for one robot.

    Args:
        scenarios: Built-in scenarios of the experiment, the default first.
    """
    built_in = ", ".join(scenarios)
    scenario = Argument(scenarios[0], f"Scenario: {built_in}, or the path of a scenario file")
    return {"scenario": scenario, **RUN_ARGUMENTS, **COMMON_ARGUMENTS}


@dataclass(frozen=True)
class NodeStart:
    """Node to start.

    Attributes:
        name: Name of node and executable.
        parameters: Parameters that differ from their defaults.
        leads_end: Whether the run ends with this node.
    """

    name: str
    parameters: Mapping[str, Value]
    leads_end: bool


@dataclass(frozen=True)
class LaunchPlan:
    """Nodes that a launch starts for one robot.

    Attributes:
        nodes: Nodes in the order in which they start.
        folder: Folder of the log, None if nothing is recorded.
        namespace: Namespace of all nodes, empty for none.
        remappings: Pairs of names, from and to.
        params_file: Parameter file, empty for none.
    """

    nodes: tuple[NodeStart, ...]
    folder: Path | None
    namespace: str
    remappings: tuple[tuple[str, str], ...]
    params_file: str


def plan_launch(given: Mapping[str, str], scratch: Path) -> LaunchPlan:
    """Plan the nodes of one robot.

    Args:
        given: Values of `run_arguments`.
        scratch: Folder for a scenario that is not an unchanged built-in one.

    Returns:
        The plan; nodes configure and activate themselves.

    Raises:
        InputError: An argument is invalid.
    """
    scenario, file = _scenario(given, scratch)
    real_time = given["realtime"] == "true"
    own: dict[str, dict[str, Value]] = {"plant": {"real_time": True}} if real_time else {}
    if given["begin_at_once"] and scenario.identification is not None:
        own["identification"] = {"begin_at_once": given["begin_at_once"] == "true"}
    folder = log_folder(given["out"], scenario.name) if given["record"] == "true" else None
    plan = RunPlan(file, folder, own, leader_of(scenario), new_identity())
    namespace = given["namespace"].strip("/")
    if namespace and not all(_is_name(part) for part in namespace.split("/")):
        raise InputError(f"namespace is '{namespace}', but must be letters, digits and _ between slashes, e.g. left")
    clock = [("/clock", "clock")] if namespace else []
    nodes = [NodeStart(name, _parameters(plan, name), name == "plant") for name in plan.nodes]
    if model := given["monitor"]:
        load_model(model)
        nominal = Path(model)
        nodes.append(
            NodeStart("gap_monitor", {"model": str(nominal.absolute()) if nominal.is_file() else model}, False)
        )
    return LaunchPlan(
        nodes=tuple(nodes),
        folder=folder,
        namespace=namespace,
        remappings=(*clock, *_remappings(given["remappings"])),
        params_file=_existing(given["params_file"]),
    )


def plan_robots(given: Mapping[str, str], scratch: Path) -> tuple[LaunchPlan, ...]:
    """Plan several robots side by side, each in a namespace.

    Args:
        given: Values of `COMMON_ARGUMENTS` and of the argument `robots`.
        scratch: Folder for scenarios.

    Returns:
        One plan per robot; each has its own subfolder of the log folder.

    Raises:
        InputError: An argument is invalid.
    """
    plans: dict[str, LaunchPlan] = {}
    parent = log_folder(given["out"], "robots") if given["record"] == "true" else Path()
    for entry in given["robots"].split(","):
        namespace, equals, scenario = (part.strip() for part in entry.partition("="))
        if not equals or not namespace or not scenario or namespace in plans:
            raise InputError(
                f"robots is '{given['robots']}', but must be NAMESPACE=SCENARIO separated by commas, each once; "
                f"e.g. {ROBOTS.default}"
            )
        defaults = {name: argument.default for name, argument in run_arguments([scenario]).items()}
        common = {name: given[name] for name in COMMON_ARGUMENTS}
        arguments = {**defaults, **common, "namespace": namespace, "out": str(parent / namespace)}
        plans[namespace] = plan_launch(arguments, scratch)
    return tuple(plans.values())


def log_folder(out: str, name: str) -> Path:
    """Return the folder of a log.

    Args:
        out: Given folder, empty for the default.
        name: Name of scenario or launch.

    Returns:
        Absolute path: the given folder, else bags/NAME_<time>.

    Raises:
        InputError: The folder exists.
    """
    folder = Path(out or f"bags/{name}_{datetime.datetime.now().astimezone():%Y%m%d_%H%M%S}").absolute()
    if folder.exists():
        raise InputError(f"the log folder {folder} exists already; choose another one with out:=FOLDER, or remove it")
    return folder


def _scenario(given: Mapping[str, str], scratch: Path) -> tuple[Scenario, str]:
    """Load the scenario with its changes, and return the name or file from which the nodes load it.

    Invalid input is rejected here: otherwise each of the nodes would report the same error.
    """
    scenario = load_scenario(given["scenario"])
    changes: dict[str, Any] = {}
    if given["robot"]:
        changes["robot"] = given["robot"]
    if given["seed"]:
        changes["seed"] = _seed(given["seed"])
    if effects := given["effects"].split():
        changes["plant.effects"] = [*scenario.plant.effects, *effects]
    if not changes:
        load_model(scenario.robot)
        built_in = given["scenario"] in scenario_names()
        return scenario, given["scenario"] if built_in else str(Path(given["scenario"]).absolute())
    changed = scenario.with_values(changes, "launch arguments")
    load_model(changed.robot)
    file = scratch / f"{changed.name or 'scenario'}{len(list(scratch.iterdir())) or ''}.yaml"
    file.write_text(json.dumps(changed.settings()), encoding="utf-8")  # JSON is YAML
    return changed, str(file)


def _seed(text: str) -> int:
    if not re.fullmatch(r"\d{1,18}", text):
        raise InputError(f"seed is '{text}', but must be a whole number, e.g. 2")
    return int(text)


def _parameters(plan: RunPlan, name: str) -> dict[str, Value]:
    """Return the parameters that differ from their defaults: a parameter file may set the others."""
    rows = node_parameters(name)
    values = {**plan.process_values(name), "autostart": True}
    return {key: value for key, value in values.items() if key == "scenario" or value != rows[key].default}


def _remappings(text: str) -> tuple[tuple[str, str], ...]:
    pairs = [pair.partition(":=") for pair in text.split()]
    for origin, sign, target in pairs:
        if not (origin and sign and target):
            raise InputError(f"remappings is '{text}', but must be FROM:=TO separated by spaces, e.g. clock:=sim_clock")
    return tuple((origin, target) for origin, _, target in pairs)


def _existing(file: str) -> str:
    if file and not Path(file).is_file():
        raise InputError(f"params_file is '{file}', but there is no such file; give the path of a parameter file")
    return file and str(Path(file).absolute())


def _is_name(text: str) -> bool:
    return re.fullmatch(r"[A-Za-z_]\w*", text, re.ASCII) is not None
