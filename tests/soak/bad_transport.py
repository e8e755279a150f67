"""A transport that loses, repeats and swaps messages between the nodes of a loop."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from flexros.logs.reader import read_log
from tests.nodes.conftest import differences
from tests.soak.result import Result, differing
from tests.soak.starting import Started, direct_log, ending, own_domain, scenario_file, start_node

PAIRS = (
    ("plant/joint_states", "joint_states"),
    ("joint_commands", "plant/joint_commands"),
    ("feedforward/joint_reference_ahead", "joint_reference_ahead"),
)
"""What the relay stands in: measurements, commands, reference."""
COUNTED = ("messages", "lost", "repeated", "swapped")
"""What the relay counts."""
SAME_MOTION = 0.01
"""Largest deviation of a motor from the undisturbed motion, over its range [1] (chosen)."""


def disturbed(folder: Path, duration: float = 5.0, seeds: Sequence[int] = (1, 2, 3), share: float = 0.05) -> Result:
    """Run a loop through the relay: its log must be that of an undisturbed run."""
    result = Result(["seed", *COUNTED, "states sent again", "log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario)
    for seed in seeds:
        work = folder / str(seed)
        work.mkdir()
        code, counts, figures = _run(work, scenario, seed, share)
        wrong = [f"exit code {code}"] * bool(code)
        wrong += ["nothing was lost or repeated"] * (not counts.get("lost") and not counts.get("repeated"))
        found = differences(wanted, read_log(work / "log"))
        wrong += [differing("the log", found)] * bool(found)
        what = "" if wrong else f"{len(wanted.joint_states.stamp):,} samples equal in every bit"
        result.add(str(seed), *_counted(counts), f"{figures['resends']:.0f}", what, wrong="; ".join(wrong))
        shutil.rmtree(work)
    return result


def disturbed_in_real_time(
    folder: Path, duration: float = 20.0, seeds: Sequence[int] = (1, 2, 3), share: float = 0.05
) -> Result:
    """Run a loop in real time through the relay: it has to go on, and the motion must hardly change."""
    result = Result(["seed", *COUNTED, "samples without command, of all", "largest deviation [% of the motion]", "log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario).joint_states
    for seed in seeds:
        work = folder / str(seed)
        work.mkdir()
        code, counts, figures = _run(work, scenario, seed, share, real_time=True)
        log = read_log(work / "log").joint_states
        recorded = np.isin(wanted.stamp, log.stamp)
        assert wanted.position is not None
        assert log.position is not None
        moved = np.abs(log.position - wanted.position[recorded]).max(axis=0) / np.ptp(wanted.position, axis=0)
        deviation = float(moved.max())
        wrong = [f"exit code {code}"] * bool(code) + ["nothing was lost"] * (not counts.get("lost"))
        wrong += ["the log lacks samples"] * (not recorded.all())
        wrong += ["another motion"] * (deviation > SAME_MOTION)
        missed = f"{figures['missed_commands']:.0f} of {figures['samples']:,.0f}"
        what = f"{recorded.sum():,} of {len(recorded):,} samples"
        result.add(str(seed), *_counted(counts), missed, f"{100 * deviation:.2g}", what, wrong="; ".join(wrong))
        shutil.rmtree(work)
    return result


def _counted(counts: Mapping[str, int]) -> list[str]:
    return [f"{counts.get(name, 0):,}" for name in COUNTED]


def _run(
    work: Path, scenario: Path, seed: int, share: float, *, real_time: bool = False
) -> tuple[int, dict[str, int], dict[str, float]]:
    """Run the nodes around the relay; give the plant's exit code, what was disturbed, and the plant's figures."""
    with own_domain() as environment:
        topics = [name for pair in PAIRS for name in pair]
        relay = Started(["-m", "tests.soak.relay", str(seed), str(share), *topics], environment, work / "relay.txt")
        with ending(relay) as take:
            to_plant = ("-r", "joint_states:=plant/joint_states", "-r", "joint_commands:=plant/joint_commands")
            ahead = ("-r", "joint_reference_ahead:=feedforward/joint_reference_ahead")
            measured = ("-r", "joint_states:=plant/joint_states")
            common = {"scenario": scenario}
            report = work / "plant.json"
            paced = {**common, "real_time": real_time}
            plant = take(start_node("plant", work, environment, *to_plant, **paced, report_file=report))
            take(start_node("controller", work, environment, **common))
            take(start_node("feedforward", work, environment, *ahead, **common))
            recorder = take(start_node("recorder", work, environment, *measured, **paced, folder=work / "log"))
            code = plant.exit_code(600.0)
            recorder.end()
    return code, relay.figures(), json.loads(report.read_text())["figures"]
