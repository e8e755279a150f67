"""Run of a scenario over ROS 2 topics (transport "ros")."""

from __future__ import annotations

import json
import os
import tempfile
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError, unknown_name
from flexros.scenario.scenario import Scenario, load_scenario
from flexros_nodes.bringup.composed import run_composed
from flexros_nodes.bringup.processes import run_processes
from flexros_nodes.bringup.run_plan import LEADERS, NODES, RunPlan, RunSummary, leader_of, new_identity
from flexros_nodes.protocol.parameters import check_value, gain_parameters, node_parameters
from flexros_nodes.protocol.process.interruption import interruption
from flexros_nodes.protocol.real_time.bare_loop import bare_loop
from flexros_nodes.shell.claims import PRODUCERS, refuse_claims_of_others
from flexros_nodes.shell.domain import DOMAIN_VARIABLE, domain_of_run, environment
from flexros_nodes.shell.exposure import exposure_settings
from flexros_nodes.shell.ros_log_folder import ros_log_settings

if TYPE_CHECKING:
    from collections.abc import Mapping
    from contextlib import AbstractContextManager

    from flexros_nodes.protocol.parameters import Value

BARE_LOOP = 2.0
"""Time for which a bare loop is measured after a run in real time, for comparison [s], chosen."""

LAYOUTS = {"composed": run_composed, "processes": run_processes}

SET_BY_THE_RUN = {
    "scenario": " from its scenario",
    "folder": " from its argument out",
    "autostart": "",
    "observers": "",
    "parent_process": "",
    "report_file": "",
    "run": "",
}
"""Parameters set by the run, and their origin."""


def run_scenario(
    scenario: Scenario | str | Path,
    out: Path | None,
    layout: str = "composed",
    *,
    real_time: bool = False,
    network: bool = False,
    parameters: Mapping[str, Mapping[str, Value]] | None = None,
    beside: AbstractContextManager[object] | None = None,
) -> RunSummary:
    """Run a scenario with plant, controller, feedforward or identification, and recorder as ROS 2 nodes.

    The run has a ROS domain of its own, and its sockets are bound to 127.0.0.1, unless the environment says otherwise.
    A process decides this once, at its first run. SIGINT and SIGTERM end a run in order.

    Args:
        scenario: The scenario, its built-in name or its file.
        out: New folder of the log; None records nothing.
        layout: "composed", all nodes in this process, or "processes", one per node.
        real_time: Pace the loop by the wall clock instead of lock-step.
        network: Let nodes on other machines take part.
        parameters: Parameter values by node, e.g. {"plant": {"drop_fraction": 0.01}}.
        beside: Entered before the nodes start and left after they ended, with the ROS domain of the run in the
            environment: a listener of its own process.

    Returns:
        Summary with exit code 0, 3 (aborted) or 130 (interrupted).

    Raises:
        InputError: Scenario, parameters, layout or log folder are not allowed.
        RunError: This process has used ROS 2 before with sockets that are open to the network.
    """
    if layout not in LAYOUTS:
        raise unknown_name("layout", layout, LAYOUTS)
    loaded = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    given = {node: _checked(node, values, loaded) for node, values in (parameters or {}).items()}
    if real_time:
        given.setdefault("plant", {})["real_time"] = True
    folder = None if out is None else Path(out).absolute()
    with (
        tempfile.TemporaryDirectory(prefix="flexros_") as scratch,
        interruption() as interrupted,
        domain_of_run(os.environ, os.getpid()) as domain,
        environment({DOMAIN_VARIABLE: str(domain), **exposure_settings(os.environ, network=network)}),
        environment(ros_log_settings(os.environ)),
        beside or nullcontext(),
    ):
        plan = RunPlan(_scenario_file(scenario, Path(scratch)), folder, given, leader_of(loaded), new_identity())
        for topic in PRODUCERS:  # before any node is started
            refuse_claims_of_others(domain, f"/{topic}", plan.run, os.environ)
        summary = replace(LAYOUTS[layout](plan, interrupted), domain_id=domain)
        if summary.timing and not interrupted():
            bare = bare_loop(summary.simulated_time / summary.samples, BARE_LOOP)
            share = {} if bare is None else {"bare_late_percent": bare.late_percent}
            summary = replace(summary, timing={**summary.timing, **share})
    if summary.exit_code == InputError.exit_code:
        raise InputError(summary.message)
    return summary


def _checked(node: str, values: Mapping[str, Value], scenario: Scenario) -> dict[str, Value]:
    """Check the given parameters of a node before anything starts."""
    if node not in NODES:
        raise unknown_name("node", node, NODES)
    if node in LEADERS and node != (leader := leader_of(scenario)):
        raise InputError(
            f"parameters of node {node} are given, but in scenario {scenario.name} node {leader} streams the "
            "reference; give its parameters"
        )
    specifications = node_parameters(node)
    if node == "controller":
        robot = load_model(scenario.robot).robot
        law = scenario.controller
        context = law.context(robot, scenario.sample_time or robot.sample_time)
        specifications |= gain_parameters(law, law.gain_names(context), law.gains(context))
    for name in values:
        if name in SET_BY_THE_RUN:
            raise InputError(
                f"parameter {name} of node {node} is given, but the run sets it{SET_BY_THE_RUN[name]}; omit it"
            )
    return {name: check_value(node, name, value, specifications) for name, value in values.items()}


def _scenario_file(scenario: Scenario | str | Path, scratch: Path) -> str:
    """Return a name or file from which every node can load the scenario; JSON is YAML."""
    if not isinstance(scenario, Scenario):
        return str(scenario)
    path = scratch / f"{scenario.name or 'scenario'}.yaml"
    path.write_text(json.dumps(scenario.settings()), encoding="utf-8")
    return str(path)
