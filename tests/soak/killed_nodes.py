"""Nodes killed and started again, in every order."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from itertools import permutations
from pathlib import Path

import psutil

from flexros.logs.reader import read_log
from tests.nodes.conftest import differences
from tests.soak.result import Result, differing
from tests.soak.starting import (
    Started,
    await_samples,
    direct_log,
    ending,
    own_domain,
    samples_in,
    scenario_file,
    start_nodes,
    start_run,
)
from tests.soak.watching import name_of

NODES = ("plant", "controller", "feedforward", "recorder")
ORDERS = list(permutations(NODES))
IMPATIENT = {"partner_timeout": 3.0, "recorder_timeout": 4.0, "brake_duration": 0.05}
MESSAGES = {
    "controller": "the controller is gone or lacks its reference; the plant has braked",
    "feedforward": "the controller is gone or lacks its reference; the plant has braked",
    "recorder": "it is gone; the plant has braked",
}
"""Messages of the plant when a node is gone."""


def killed_in_a_run(folder: Path, victims: Sequence[str] = NODES) -> Result:
    """Kill one node of `flexros run --layout processes`, in lock-step and in real time."""
    result = Result(["killed", "loop", "exit code", "message of the run", "samples in the log"])
    for victim in victims:
        for options in ((), ("--realtime",)):
            work = folder / f"{victim}{len(options)}"
            work.mkdir(parents=True)
            run = start_run(work, str(scenario_file(work, "circle_dae", 60.0)), "--layout", "processes", *options)
            with ending(run):
                await_samples(run, work)
                children = {name_of(one): one for one in psutil.Process(run.pid).children()}
                children[victim].kill()
                code = run.exit_code()
            samples = samples_in(work / "log")
            said = run.last_sentence()
            alive = [name for name, one in children.items() if one.is_running()]
            wrong = [f"exit code {code}"] * (code != 3) + ["few samples"] * (samples < 500)
            wrong += ["not reported"] * (f"the process of node {victim} was killed by SIGKILL" not in said)
            wrong += [f"{', '.join(alive)} left"] * bool(alive)
            result.add(
                victim, "real time" if options else "lock-step", str(code), said, str(samples), wrong="; ".join(wrong)
            )
            shutil.rmtree(work)
    return result


def killed_in_order(folder: Path, orders: Sequence[Sequence[str]] = ORDERS, duration: float = 1.0) -> Result:
    """Kill nodes that were started by themselves, in an order; then start all again in that order.

    After the first kill the plant has to notice; the log must be readable though its recorder was killed too; and what
    is started again in the same domain must give the log of an undisturbed run.
    """
    result = Result(["order", "message of the plant", "samples in the log", "restarted"])
    again = folder / "again"
    again.mkdir(parents=True)
    wanted = direct_log(scenario_file(again, "circle_dae", duration))
    for order in orders:
        work, anew = folder / "first", again / "run"
        work.mkdir()
        anew.mkdir()
        with own_domain() as environment:
            said, wrong = _kill_all(order, work, environment)
            samples = samples_in(work / "log")
            wrong += ["few samples"] * (samples < 500)
            nodes = start_nodes(order, anew, again / "scenario.yaml", environment)
            with ending(*nodes.values()):
                code = nodes["plant"].exit_code()
                wrong += [f"started again: exit code {code}, {nodes['plant'].last_sentence()}"] * bool(code)
        found = differences(wanted, read_log(anew / "log"))
        wrong += [differing("the log of the second run", found)] * bool(found)
        result.add(
            ", ".join(order), said, str(samples), "log equal in every bit" if not wrong else "", wrong="; ".join(wrong)
        )
        shutil.rmtree(work)
        shutil.rmtree(anew)
    return result


def _kill_all(order: Sequence[str], work: Path, environment: dict[str, str]) -> tuple[str, list[str]]:
    """Kill all nodes in an order; give what the plant said after the first one, and what is wrong."""
    nodes = start_nodes(NODES, work, scenario_file(work, "circle_dae", 60.0), environment, **IMPATIENT)
    plant, first = nodes["plant"], order[0]
    wrong: list[str] = []
    with ending(*nodes.values()):
        await_samples(plant, work)
        nodes[first].kill()
        if first != "plant":
            code = plant.exit_code()
            wrong += [f"exit code {code}"] * (code != 3)
            wrong += ["not reported"] * (MESSAGES[first] not in plant.last_sentence())
        for name in order[1:]:
            if name != "plant" and nodes[name].ended:
                wrong.append(f"{name} ended by itself")
            nodes[name].kill()
    return plant.last_sentence() or "(killed)", wrong


def killed_and_back(folder: Path, victims: Sequence[str] = NODES, duration: float = 6.0) -> Result:
    """Kill a node in the midst of a loop and start it again at once, while its partners are patient."""
    result = Result(["killed and restarted", "loop", "exit code of the plant", "log of the first recorder"])
    wanted = direct_log(scenario_file(_made(folder / "scenario"), "circle_dae", duration))
    for victim in victims:
        work = _made(folder / victim)
        scenario = folder / "scenario" / "scenario.yaml"
        with own_domain() as environment:
            nodes = start_nodes(NODES, work, scenario, environment)
            with ending(*nodes.values()) as take:
                await_samples(nodes["plant"], work)
                nodes[victim].kill()
                back = take(_again(victim, work, scenario, environment))
                plant = back if victim == "plant" else nodes["plant"]
                code = plant.exit_code()
        log = read_log(work / "log")
        n = len(log.joint_states.stamp)
        found = differences(wanted, log)
        what = "equal in every bit" if not found else f"{n} of {len(wanted.joint_states.stamp)} samples"
        loop = "went on" if code == 0 else plant.last_sentence()
        wrong = f"exit code {code}" if code not in (0, 3) else "" if loop else "nothing said"
        result.add(victim, loop, str(code), what, wrong=wrong)
        shutil.rmtree(work)
    return result


def _again(victim: str, work: Path, scenario: Path, environment: dict[str, str]) -> Started:
    return start_nodes([victim], _made(work / "again"), scenario, environment)[victim]


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder
