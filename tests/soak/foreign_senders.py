"""Nodes that do not belong to the run: a flood of garbage, wrong types, and a second controller."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from flexros.logs.reader import read_log
from flexros_nodes.shell.domain import DOMAIN_VARIABLE
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
    start_node,
    start_run,
)

RATE = 10_000.0
"""Messages per second of a flood [1/s]."""

FLOODS = {
    "bytes": "random bytes, 0 to 300, on joint_commands",
    "sizes": "commands with 1 and with 50 joints, stamps of other times",
    "not_finite": "commands of NaN and infinity, stamps of other times",
    "denormal": "commands of numbers below 1e-307, stamps of other times",
    "trajectories": "random bytes on joint_trajectory",
    "bad_trajectories": "trajectories of NaN, of other joints and with times that do not increase, on joint_trajectory",
    "type": "messages of type std_msgs/String on joint_commands",
}
"""Kinds of messages, by their names in flood.py."""


def flooded(folder: Path, kinds: Sequence[str] = tuple(FLOODS), duration: float = 20.0, rate: float = RATE) -> Result:
    """Flood a loop in lock-step while it runs: its log must be that of an undisturbed run."""
    result = Result(["flood", "sent", "rate [1/s]", "samples/s, without and with flood", "log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario)
    alone = _run(folder / "alone", scenario, None, rate)[1]["samples_per_second"]
    for kind in kinds:
        work = folder / kind
        code, figures, flood = _run(work, scenario, kind, rate)
        wrong = [f"exit code {code}"] * bool(code) + ["no flood"] * (flood["sent"] < 100)
        found = differences(wanted, read_log(work / "log"))
        wrong += [differing("the log", found)] * bool(found)
        what = "" if wrong else "equal in every bit"
        speeds = f"{alone:,.0f}, {figures['samples_per_second']:,.0f}"
        result.add(FLOODS[kind], f"{flood['sent']:,}", f"{flood['rate']:,.0f}", speeds, what, wrong="; ".join(wrong))
        shutil.rmtree(work)
    return result


def flooded_in_real_time(folder: Path, kinds: Sequence[str] = tuple(FLOODS), duration: float = 20.0) -> Result:
    """Flood a loop in real time: it has to go on, and its log must hold all that the nodes of the loop have sent."""
    result = Result(["flood", "sent", "samples without command, of all", "late cycles [%]", "messages lost by the log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    for kind in (None, *kinds):
        work = folder / (kind or "alone")
        code, figures, flood = _run(work, scenario, kind, RATE, "--realtime", "--layout", "processes")
        missed = f"{figures['missed_commands']:.0f} of {figures['samples']:,}"
        lost = figures["missing_in_log"]
        wrong = [f"exit code {code}"] * bool(code) + ["the log lacks samples"] * bool(lost)
        late = f"{figures['late_percent']:.1f}"
        result.add(
            FLOODS[kind] if kind else "none",
            f"{flood.get('sent', 0):,}",
            missed,
            late,
            str(lost),
            wrong="; ".join(wrong),
        )
        shutil.rmtree(work)
    return result


def _run(
    work: Path, scenario: Path, kind: str | None, rate: float, *options: str
) -> tuple[int, Mapping[str, float], Mapping[str, float]]:
    """Run during a flood; return exit code, figures of the run and of the flood."""
    work.mkdir(parents=True)
    with own_domain() as environment:
        run = start_run(work, str(scenario), *options, **{DOMAIN_VARIABLE: environment[DOMAIN_VARIABLE]})
        with ending(run) as take:
            flood = None
            if kind:
                flood = take(Started(["-m", "tests.soak.flood", kind, str(rate)], environment, work / "flood.txt"))
            code = run.exit_code(900.0)
            if flood is not None:
                flood.end()
    return code, run.figures(), flood.figures() if flood else {}


def second_controller(folder: Path) -> Result:
    """Run with a second controller of other gains that joins."""
    result = Result(["loop", "exit code", "message of the run", "samples in the log"])
    for options in ((), ("--realtime",)):
        work = folder / f"second{len(options)}"
        work.mkdir(parents=True)
        scenario = scenario_file(work, "circle_dae", 120.0)
        settings = {**json.loads(scenario.read_text()), "controller": {"kind": "pid", "kp": 100_000, "kd": 7000}}
        other = work / "other.yaml"
        other.write_text(json.dumps(settings))
        with own_domain() as environment:
            run = start_run(work, str(scenario), *options, **{DOMAIN_VARIABLE: environment[DOMAIN_VARIABLE]})
            with ending(run) as take:
                await_samples(run, work)
                take(start_node("controller", work, environment, scenario=other, observers=0))
                code = run.exit_code(300.0)
        said, samples = run.last_sentence(), samples_in(work / "log")
        wrong = [f"exit code {code}"] * (code != 3) + ["not reported"] * ("a plant accepts one controller" not in said)
        result.add("real time" if options else "lock-step", str(code), said, str(samples), wrong="; ".join(wrong))
        shutil.rmtree(work)
    return result
