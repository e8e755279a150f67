"""Starting runs and nodes as a user does: from a shell without middleware settings, each in a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros_nodes.protocol.node_report import ERROR_PREFIX
from flexros_nodes.shell.domain import DOMAIN_VARIABLE, domain_of_run
from flexros_nodes.shell.exposure import exposure_settings

CHECKOUT = Path(__file__).resolve().parents[2]
COMMAND = "from flexros.cli import main; raise SystemExit(main())"
PATIENCE = 120.0
"""Longest wait for anything that has to come [s], chosen for a loaded machine."""


def user_environment(**settings: str) -> dict[str, str]:
    """Return an environment with the checkout and the given settings, without those of ROS."""
    kept = {name: text for name, text in os.environ.items() if not name.startswith(("ROS_", "RMW_", "FAST"))}
    return {**kept, "PYTHONPATH": str(CHECKOUT), "OMP_NUM_THREADS": "1", **settings}


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Return the environment of nodes that communicate: a domain of their own, on this machine only."""
    with domain_of_run({}, os.getpid()) as domain:
        yield user_environment(**{DOMAIN_VARIABLE: str(domain)}, **exposure_settings({}, network=False))


class Started:
    """A process that was started, with what it says in a file."""

    def __init__(self, arguments: list[str], environment: Mapping[str, str], said: Path) -> None:
        self.said = said
        with said.open("wb") as output:
            self.process = subprocess.Popen(
                [sys.executable, *arguments],
                cwd=CHECKOUT,
                env=dict(environment),
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def pid(self) -> int:
        return self.process.pid

    @property
    def ended(self) -> bool:
        return self.process.poll() is not None

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def exit_code(self, timeout: float = PATIENCE) -> int:
        """Wait for the end."""
        return self.process.wait(timeout)

    def end(self) -> None:
        """End the process, if it has not ended: ask, and make it after a while."""
        if not self.ended:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            try:
                self.process.wait(20.0)
            except subprocess.TimeoutExpired:
                self.kill()

    def words(self) -> str:
        return self.said.read_text(encoding="utf-8", errors="replace")

    def last_sentence(self) -> str:
        """Return the last message of a node or command."""
        for line in reversed(self.words().splitlines()):
            for prefix in ("flexros: ", ERROR_PREFIX):
                if line.startswith(prefix):
                    return line.removeprefix(prefix).replace(str(self.said.parent), "FOLDER")
        return ""

    def figures(self) -> dict[str, Any]:
        """Read what a command printed as JSON."""
        text = self.words()
        content: dict[str, Any] = json.loads(text[text.index("{") : text.rindex("}") + 1])
        return content


def start_run(folder: Path, *options: str, **settings: str) -> Started:
    """Start `flexros run`; the log is `folder/log`."""
    arguments = ["-c", COMMAND, "run", *options, "--transport", "ros", "--out", str(folder / "log"), "--json"]
    return Started(arguments, user_environment(**settings), folder / "said.txt")


def start_node(
    name: str, folder: Path, environment: Mapping[str, str], /, *words: str, **parameters: object
) -> Started:
    """Start a node by itself, as `ros2 run` does."""
    given = [word for key, value in parameters.items() for word in ("-p", f"{key}:={value}")]
    arguments = ["-m", f"flexros_nodes.{name}", "--ros-args", *given, *words]
    return Started(arguments, environment, folder / f"{name}.txt")


@contextmanager
def ending(*first: Started) -> Iterator[Callable[[Started], Started]]:
    """Yield a function that registers processes; they end with the block."""
    with ExitStack() as stack:

        def take(one: Started) -> Started:
            stack.callback(one.end)
            return one

        for one in first:
            take(one)
        yield take


def wait_until(condition: Callable[[], bool], what: str, timeout: float = PATIENCE) -> None:
    """Wait, looking now and then."""
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"{what} did not come within {timeout:g} s")
        time.sleep(0.05)


def await_samples(process: Started, folder: Path, size: int = 300_000, timeout: float = PATIENCE) -> None:
    """Wait until the log below a folder has some size [bytes], or the process has ended."""
    file = folder / "log" / "log_0.mcap"
    wait_until(lambda: process.ended or (file.is_file() and file.stat().st_size > size), "the first samples", timeout)


def scenario_file(folder: Path, scenario: str, duration: float) -> Path:
    """Write a built-in scenario with another duration [s]."""
    settings = {**load_scenario(scenario).settings(), "duration": duration, "name": f"{scenario}_{duration:g}s"}
    path = folder / "scenario.yaml"
    path.write_text(json.dumps(settings), encoding="utf-8")
    return path


def direct_log(scenario: Path) -> Log:
    """Simulate a scenario without topics: what a log has to equal."""
    return closed_loop(Experiment.prepare(load_scenario(scenario)))


def start_nodes(
    names: Sequence[str], folder: Path, scenario: Path, environment: Mapping[str, str], **plant: object
) -> dict[str, Started]:
    """Start nodes by themselves in an order; the recorder writes to `folder/log`."""
    started = {}
    for name in names:
        own: dict[str, object] = {"folder": folder / "log"} if name == "recorder" else plant if name == "plant" else {}
        started[name] = start_node(name, folder, environment, scenario=scenario, **own)
    return started


def samples_in(log: Path) -> int:
    """Count the samples of a log, also of one that was never closed; 0 where not even one chunk was written."""
    try:
        return len(read_log(log).joint_states.stamp)
    except InputError:
        return 0
