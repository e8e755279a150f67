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
from tests.soak.starting import Started, direct_log, ending, own_domain, scenario_file, start_node, start_run

PAIRS = (
    ("plant/joint_states", "joint_states"),
    ("joint_commands", "plant/joint_commands"),
    ("feedforward/joint_reference_ahead", "joint_reference_ahead"),
    ("controller/reference_received", "reference_received"),
)
"""Topics through the relay: measurements, commands, reference and its confirmation."""
COUNTED = ("messages", "lost", "repeated", "swapped")
"""Counters of the relay."""
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


def lossy_in_real_time(
    folder: Path, duration: float = 20.0, seeds: Sequence[int] = (1, 2, 3), share: float = 0.05
) -> Result:
    """Run a loop in real time whose plant and controller do not see some messages: the motion must hardly change.

    A relay in Python is too slow for 2 kHz, so the nodes themselves drop what reaches them. The first run loses
    nothing: it shows what the lateness of the machine does alone.
    """
    result = Result(
        [
            "seed",
            "commands lost",
            "samples without command, of all",
            "largest lateness of a cycle [ms]",
            "largest deviation [%]",
            "message of the run",
            "log",
        ]
    )
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario).joint_states
    for seed in (None, *seeds):
        work = folder / str(seed)
        work.mkdir()
        drops = [
            f"{node}.drop_{key}={value}"
            for node in ("plant", "controller")
            for key, value in (("fraction", share), ("seed", seed))
            if seed is not None
        ]
        options = [word for drop in drops for word in ("--parameter", drop)]
        run = start_run(work, str(scenario), "--realtime", "--layout", "processes", *options)
        with ending(run):
            code = run.exit_code(600.0)
        figures, log = run.figures(), read_log(work / "log").joint_states
        both, recorded, planned = np.intersect1d(log.stamp, wanted.stamp, return_indices=True)
        assert wanted.position is not None
        assert log.position is not None
        moved = np.abs(log.position[recorded] - wanted.position[planned]).max(axis=0) / np.ptp(wanted.position, axis=0)
        deviation = float(moved.max())
        wrong = [f"exit code {code}"] * bool(code) + ["nothing was lost"] * (
            seed is not None and not figures["dropped_on_purpose"]
        )
        wrong += ["the log lacks samples"] * (len(both) < len(wanted.stamp))
        wrong += ["another motion"] * (deviation > SAME_MOTION)
        missed = f"{figures['missed_commands']:,.0f} of {figures['samples']:,.0f}"
        what = f"{len(both):,} of {len(wanted.stamp):,} samples"
        lost = f"{figures['dropped_on_purpose']:,.0f}"
        late = f"{figures['lateness_max_us'] / 1e3:.1f}"
        said, wrong_text = run.last_sentence(), "; ".join(wrong)
        result.add(
            "none" if seed is None else str(seed),
            lost,
            missed,
            late,
            f"{100 * deviation:.2g}",
            said,
            what,
            wrong=wrong_text,
        )
        shutil.rmtree(work)
    return result


def _counted(counts: Mapping[str, int]) -> list[str]:
    return [f"{counts.get(name, 0):,}" for name in COUNTED]


def _run(work: Path, scenario: Path, seed: int, share: float) -> tuple[int, dict[str, int], dict[str, float]]:
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
            plant = take(start_node("plant", work, environment, *to_plant, **common, report_file=report))
            received = ("-r", "reference_received:=controller/reference_received")
            take(start_node("controller", work, environment, *received, **common))
            take(start_node("feedforward", work, environment, *ahead, **common))
            recorder = take(start_node("recorder", work, environment, *measured, **common, folder=work / "log"))
            code = plant.exit_code(600.0)
            recorder.end()
    return code, relay.figures(), json.loads(report.read_text())["figures"]
