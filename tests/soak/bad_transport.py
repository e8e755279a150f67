"""A transport that loses, repeats and swaps messages between the nodes of a loop."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path

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


def disturbed(folder: Path, duration: float = 5.0, seeds: Sequence[int] = (1, 2, 3), share: float = 0.05) -> Result:
    """Run a loop through the relay: its log must be that of an undisturbed run."""
    result = Result(["seed", "messages", "lost", "repeated", "swapped", "states sent again", "log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario)
    for seed in seeds:
        work = folder / str(seed)
        work.mkdir()
        code, counts, report = _run(work, scenario, seed, share)
        wrong = [f"exit code {code}"] * bool(code)
        wrong += ["nothing was lost or repeated"] * (not counts.get("lost") and not counts.get("repeated"))
        found = differences(wanted, read_log(work / "log"))
        wrong += [differing("the log", found)] * bool(found)
        figures = [f"{counts.get(name, 0):,}" for name in ("messages", "lost", "repeated", "swapped")]
        what = "" if wrong else f"{len(wanted.joint_states.stamp):,} samples equal in every bit"
        result.add(str(seed), *figures, f"{report:.0f}", what, wrong="; ".join(wrong))
        shutil.rmtree(work)
    return result


def _run(work: Path, scenario: Path, seed: int, share: float) -> tuple[int, dict[str, int], float]:
    """Run the nodes around the relay; give the plant's exit code, what was disturbed, and the states sent again."""
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
            take(start_node("controller", work, environment, **common))
            take(start_node("feedforward", work, environment, *ahead, **common))
            recorder = take(start_node("recorder", work, environment, *measured, **common, folder=work / "log"))
            code = plant.exit_code(600.0)
            recorder.end()
    return code, relay.figures(), json.loads(report.read_text())["figures"]["resends"]
