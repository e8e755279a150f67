"""Disks that are full: on a file system of its own, where the system permits it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.soak.own_mounts import mounts_are_allowed, with_mount
from tests.soak.result import Result
from tests.soak.starting import CHECKOUT, COMMAND, PATIENCE, samples_in, scenario_file, user_environment

_CHECK = "import sys; from pathlib import Path; from tests.soak.full_disk import run_here; run_here(*sys.argv[1:])"


def full_disk(
    folder: Path, layouts: Sequence[str] = ("composed", "processes"), sizes: Sequence[str] = ("64k", "2m")
) -> Result:
    """Record onto a disk that is too small: the run must end in order, and the log be valid up to that point."""
    result = Result(["layout", "disk", "exit code", "message of the run", "samples in the log"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario, disk = scenario_file(folder, "circle_dae", 60.0), folder / "disk"
    disk.mkdir()
    if not mounts_are_allowed(disk):
        result.notes.append("Not run: this user may not mount a file system.")
        return result
    for layout in layouts:
        for size in sizes:
            command = [sys.executable, "-c", _CHECK, str(scenario), layout, str(disk)]
            output = subprocess.check_output(
                with_mount(command, disk, size), cwd=CHECKOUT, env=user_environment(), text=True, timeout=PATIENCE
            )
            found = json.loads(output)
            wrong = [f"exit code {found['code']}"] * (found["code"] != 3)
            wrong += ["not reported"] * ("make space and run again" not in found["said"])
            wrong += ["few samples"] * (size != "64k" and found["samples"] < 500)
            texts = (layout, size, str(found["code"]), found["said"], str(found["samples"]))
            result.add(*texts, wrong="; ".join(wrong))
    return result


def run_here(scenario: str, layout: str, disk: str) -> None:
    """Run onto a disk, and print what came of it, as JSON; the disk is gone when this process ends."""
    log = Path(disk) / "log"
    command = [
        sys.executable,
        "-c",
        COMMAND,
        "run",
        scenario,
        "--transport",
        "ros",
        "--layout",
        layout,
        "--out",
        str(log),
    ]
    ended = subprocess.run([*command, "--json"], capture_output=True, text=True, timeout=PATIENCE, check=False)
    sentences = [line for line in ended.stderr.splitlines() if line.startswith("flexros: ")]
    samples = samples_in(log)
    said = sentences[-1].removeprefix("flexros: ").replace(disk, "DISK") if sentences else ended.stderr[-300:]
    print(json.dumps({"code": ended.returncode, "said": said, "samples": samples}))
