"""Time the first hour of README.md: python docs/results/programs/first_hour.py, with ROS 2 and Chromium.

Each block of the section runs as it is printed, in a folder of its own. The times are written into README.md and
first_hour.md.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import platform
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

CHECKOUT = Path(__file__).parents[3]
sys.path.insert(0, str(CHECKOUT))

from tests.browser import opened_browser, wait  # noqa: E402
from tests.contracts.conftest import folder_of_reader, marked_blocks, run_block  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np

README = CHECKOUT / "README.md"
MARKER = "run by tests/contracts/test_first_hour.py"
VIEW = re.compile(r"^flexros view .*$", re.MULTILINE)

HEAD = """# The first hour, timed

Written by `python docs/results/programs/first_hour.py`.
The four things a new user wants to see, by the commands of the section
*First hour* of `README.md`, after `make demo` has installed everything. Wall time is that of the machine, with whatever
else ran on it, and without the download of packages; processor time is that of all processes of the journey but the
browser. Goal: each in under ten minutes. `tests/contracts/test_first_hour.py` runs the same.

Machine: {machine}.

| journey | more about it | wall [s] | processor [s] |
|---|---|---|---|
{rows}

The arm counts as moving when two pictures of a headless Chromium, which draws without a graphics card, differ where
the arm is.
"""

PAGES = {
    "A moving arm in the browser": "how-to/view.md",
    "Your own controller on the six-axis robot, over ROS 2 topics": "how-to/own_controller.md",
    "A repaired model of a UR5e from a bag": "tutorials/ur5e.md",
    "A notebook with a frequency response": "notebooks/overview.md",
}
"""What a new user has at the end of each block of the README, and the page that tells more."""


@dataclass(frozen=True)
class Journey:
    """A block of the section First hour.

    Attributes:
        name: What a user has at the end: the comment above the commands.
        seconds: Time that the README states [s].
        commands: The commands as printed.
    """

    name: str
    seconds: int
    commands: str

    @property
    def over_topics(self) -> bool:
        """Whether it needs ROS 2."""
        return "ROS_DOMAIN_ID" in self.commands

    def run(self, folder: Path, variables: dict[str, str]) -> None:
        """Run the commands in a folder; a page that `flexros view` opens is looked at in Chromium.

        Raises:
            SystemExit: A command failed; the text is what the block printed.
        """
        output = folder / "output"
        if code := run_block(VIEW.sub("", self.commands), folder, variables, output):
            raise SystemExit(f"code {code}: {output.read_text(encoding='utf-8', errors='replace')}")
        for command in VIEW.findall(self.commands):
            see_arm_move(command, folder, variables)


def journeys() -> list[Journey]:
    """Return the journeys of the README in its order."""
    found = []
    for block in marked_blocks(README.read_text(encoding="utf-8"), MARKER):
        title, commands = block.split("\n", 1)
        name, seconds = title.removeprefix("# ").removesuffix(" s").rsplit(": ", 1)
        found.append(Journey(name, int(seconds), commands))
    return found


def see_arm_move(command: str, folder: Path, variables: dict[str, str]) -> None:
    """Open a page of the viewer and wait until the arm moves in Chromium."""
    quiet = {**variables, "BROWSER": "true"}  # the page is opened here, not by the viewer
    words = command.split("#")[0].split()
    view = subprocess.Popen(words, cwd=folder, env=quiet, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)  # noqa: S603
    try:
        assert view.stdout is not None
        address = re.search(r"http://\S+", view.stdout.readline())
        assert address is not None
        with opened_browser() as browser:
            browser.size(900, 420)
            browser.open(address[0])

            def blue() -> np.ndarray:
                picture = browser.picture()[160:, :510].astype(int)
                found: np.ndarray = (picture[:, :, 2] - picture[:, :, 0] > 60) & (picture[:, :, 1] > picture[:, :, 0])
                return found

            wait(lambda: bool(blue().sum() > 400), 120, "the arm to be drawn")
            before = blue()
            wait(lambda: bool((blue() ^ before).sum() > 0.02 * before.sum()), 120, "the arm to move")
    finally:
        view.send_signal(signal.SIGINT)
        view.wait(20)


@contextlib.contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Give the environment variables of a ROS domain that no other run on this machine uses."""
    from flexros_nodes.shell.domain import claim_domain

    number, claim = claim_domain(os.getpid())
    with claim:
        yield {"ROS_DOMAIN_ID": str(number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def used() -> float:
    """Return the processor time of all processes that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def timed(journey: Journey) -> tuple[float, float]:
    """Run a journey and return wall and processor time [s]."""
    with tempfile.TemporaryDirectory(prefix="first_hour_") as scratch, contextlib.ExitStack() as stack:
        folder, variables = folder_of_reader(Path(scratch))
        variables |= {"PYTHONPATH": str(CHECKOUT)}
        if journey.over_topics:
            variables |= stack.enter_context(own_domain())
        begun, before = time.monotonic(), used()
        journey.run(folder, variables)
        return time.monotonic() - begun, used() - before


def main() -> None:
    """Time all journeys; write the page and the times of the README."""
    assert __doc__ is not None
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    rows, times = [], {}
    for journey in journeys():
        wall, processor = timed(journey)
        rows.append(f"| {journey.name} | [page](../{PAGES[journey.name]}) | {wall:.0f} | {processor:.0f} |")
        times[f"# {journey.name}: {journey.seconds} s\n"] = f"# {journey.name}: {wall:.0f} s\n"
        print(rows[-1], flush=True)
    machine = (
        f"{os.cpu_count()} processors ({platform.machine()}) of a shared server, Python {platform.python_version()}"
    )
    page = HEAD.format(machine=machine, rows="\n".join(rows))
    (Path(__file__).parents[1] / "first_hour.md").write_text(page, encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    for before, after in times.items():
        text = text.replace(before, after)
    README.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
