"""Write first_hour.md: python docs/results/first_hour.py, in the checkout, with ROS 2 and Chromium.

Each journey of a new user runs as its page prints it, in a folder of its own, and is timed.
"""

from __future__ import annotations

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

CHECKOUT = Path(__file__).parents[2]
sys.path.insert(0, str(CHECKOUT))

from flexros_nodes.shell.domain import claim_domain  # noqa: E402
from tests.browser import opened_browser, wait  # noqa: E402
from tests.contracts.conftest import folder_of_reader, marked_blocks, run_block  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np

MARKER = "run by tests/contracts/test_guide.py"
PORT = 18480

HEAD = """# The first hour, timed

Written by `python docs/results/first_hour.py`. The four things a new user wants to see, by the commands of their
pages, after `make demo` has installed everything; the simulated UR5e needs `pip install mujoco rosbags`, notebooks
`pip install jupyterlab`. Wall time is that of the machine, with whatever else ran on it; processor time is that of all
processes of the journey but the browser. Goal: each in under ten minutes.

Machine: {machine}.

| journey | page | wall [s] | processor [s] |
|---|---|---|---|
{rows}

Tests that run the same:

{tests}

The arm counts as moving when two pictures of a headless Chromium, which draws without a graphics card, differ where
the arm is.
"""


@dataclass(frozen=True)
class Journey:
    """Something a new user does.

    Attributes:
        name: What they have at the end.
        page: Page with the commands, relative to docs.
        test: File and name of the test that runs the same.
        run: Runs it in a folder with the environment of the commands.
    """

    name: str
    page: str
    test: str
    run: Callable[[Path, dict[str, str]], None]


def moving_arm(folder: Path, variables: dict[str, str]) -> None:
    """Run the circle test, open its log in the viewer, and wait until the arm moves in Chromium."""
    block(["flexros run circle_dae --transport direct --out circle"], folder, variables)
    command = ["flexros", "view", "circle", "--no-browser", "--port", str(PORT)]
    view = subprocess.Popen(command, cwd=folder, env=variables, stdout=subprocess.PIPE, text=True)  # noqa: S603
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


def own_controller(folder: Path, variables: dict[str, str]) -> None:
    """Run the block of the page that is about the six-axis robot."""
    blocks = blocks_of("how-to/own_controller.md", f"{MARKER} with ROS 2")
    number, claim = claim_domain(os.getpid())
    own = {**variables, "ROS_DOMAIN_ID": str(number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with claim:
        block([one for one in blocks if "six_axis" in one], folder, own)


def repaired_ur5e(folder: Path, variables: dict[str, str]) -> None:
    """Run the tutorial: bag of a simulated UR5e, import, gap, diagnosis, second bag, repaired URDF."""
    block(blocks_of("tutorials/ur5e.md", MARKER), folder, variables)
    assert (folder / "repaired.urdf").is_file()


def notebook(folder: Path, variables: dict[str, str]) -> None:
    """Execute the notebook with frequency responses."""
    block(["python -c 'from nbclient.cli import main; main()' docs/notebooks/identify.ipynb"], folder, variables)


JOURNEYS = (
    Journey(
        "a moving arm in the browser",
        "how-to/view.md",
        "tests/view/test_pages_in_browser.py::test_arm_moves_by_itself",
        moving_arm,
    ),
    Journey(
        "a controller of their own on the six-axis robot",
        "how-to/own_controller.md",
        "tests/contracts/test_guide.py::test_marked_commands_run_with_ros",
        own_controller,
    ),
    Journey(
        "a repaired model of a UR5e from a bag",
        "tutorials/ur5e.md",
        "tests/contracts/test_guide.py::test_marked_commands_run",
        repaired_ur5e,
    ),
    Journey(
        "a notebook with a frequency response",
        "notebooks/overview.md",
        "tests/contracts/test_notebooks.py::test_notebook_runs_and_shows_tables_and_pictures",
        notebook,
    ),
)


def blocks_of(page: str, marker: str) -> list[str]:
    """Return the marked blocks of a page."""
    return marked_blocks((CHECKOUT / "docs" / page).read_text(encoding="utf-8"), marker)


def block(blocks: list[str], folder: Path, variables: dict[str, str]) -> None:
    """Run blocks in one folder; what one prints is shown where it fails."""
    assert blocks
    output = folder / "output"
    for one in blocks:
        code = run_block(one, folder, variables, output)
        if code:
            raise SystemExit(output.read_text(encoding="utf-8", errors="replace"))


def used() -> float:
    """Return the processor time of all processes that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def timed(journey: Journey) -> tuple[float, float]:
    """Run a journey and return wall and processor time [s]."""
    with tempfile.TemporaryDirectory(prefix="first_hour_") as scratch:
        folder, variables = folder_of_reader(Path(scratch))
        variables |= {"PYTHONPATH": str(CHECKOUT)}
        begun, before = time.monotonic(), used()
        journey.run(folder, variables)
        return time.monotonic() - begun, used() - before


def main() -> None:
    """Time all journeys and write the page."""
    rows = []
    for journey in JOURNEYS:
        wall, processor = timed(journey)
        rows.append(f"| {journey.name} | [page](../{journey.page}) | {wall:.0f} | {processor:.0f} |")
        print(rows[-1], flush=True)
    machine = (
        f"{os.cpu_count()} processors ({platform.machine()}) of a shared server, Python {platform.python_version()}"
    )
    tests = "\n".join(f"- {journey.name}: `{journey.test}`" for journey in JOURNEYS)
    page = HEAD.format(machine=machine, rows="\n".join(rows), tests=tests)
    Path(__file__).with_suffix(".md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
