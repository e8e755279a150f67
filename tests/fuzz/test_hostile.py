"""Inputs made to take memory, time or the process: rejected or skipped, in a process with a small memory limit."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz.fixed_faults import FIXED_FAULTS
from tests.fuzz.hostile import HOSTILE
from tests.fuzz.readers import READERS, outcome

pytestmark = pytest.mark.slow

CHECKOUT = Path(__file__).parents[2]
ROOM = 2**30
"""Memory beyond what the process has when all is imported [byte]; some inputs claim a hundred times that."""
READ = {
    *("log: chunk of 4 GB", "log: chunk that expands without end", "log: chunks that expand to 6 GB"),
    *("log: lz4 chunks that expand", "log: damaged chunks without number", "log: empty messages without number"),
    *("log: long topic that clears the screen", "replay: topic that clears the screen"),
    *("log: new names in every message", "metadata: one file many times", "metadata: aliases of aliases"),
    *("provenance: deep lists", "provenance: two megabytes", "recorded: stamp before 1970"),
    "metadata: file with a long name",
}
"""Those that hold something that can be read; messages may be read with a claim at a place that has no meaning."""


def outcomes_in_little_memory(room: int) -> dict[str, str]:
    """Read all inputs in this process, with so much memory more than it has now; errors that say so are faults."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + room, used + room))
    found = {}
    for name, (reader, make) in HOSTILE.items():
        try:
            found[name] = outcome(READERS[reader], make())
        except BaseException as error:  # noqa: BLE001 - whatever it is, the others are tried too
            found[name] = f"{type(error).__name__}: {error}"
    return found


@pytest.fixture(scope="module")
def outcomes() -> dict[str, str]:
    program = "import json; from tests.fuzz.test_hostile import *; print(json.dumps(outcomes_in_little_memory(ROOM)))"
    ended = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, cwd=CHECKOUT, check=False
    )
    assert ended.returncode == 0, ended.stderr
    outcomes: dict[str, str] = json.loads(ended.stdout.splitlines()[-1])
    return outcomes


def test_fixed_faults_stay_tested() -> None:
    assert set(FIXED_FAULTS) <= set(HOSTILE)


def _names(messages: bool) -> list[str]:
    return [name for name in HOSTILE if ("count of 4 G" in name) == messages]


@pytest.mark.parametrize("name", _names(messages=False))
def test_hostile_file(outcomes: dict[str, str], name: str) -> None:
    assert outcomes[name] == ("read" if name in READ else "refused")


@pytest.mark.parametrize("name", _names(messages=True))
def test_hostile_message(outcomes: dict[str, str], name: str) -> None:
    assert outcomes[name] in ("read", "refused")
