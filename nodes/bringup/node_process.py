"""A node as a child process: started, watched and stopped; free of ROS."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import flexros_nodes
from flexros.errors import InputError, RunError
from flexros_nodes.protocol.node_report import ERROR_PREFIX, NodeReport, read_report
from flexros_nodes.protocol.process.interruption import PARTNER_ENDED

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros_nodes.protocol.parameters import Value

_IMPORT_FOLDER = Path(flexros_nodes.__file__ or "").parent.parent
_LAST_LINES = 5


class NodeProcess:
    """One node in a process of its own, which does not outlive this one.

    It stands in a process group of its own, so that Ctrl-C in the terminal reaches the parent alone and the nodes go
    down in order.

    Args:
        name: Node, one of the modules of this package.
        values: Parameter values.
        scratch: Folder for the parameter file, the report and what the node prints.
    """

    def __init__(self, name: str, values: Mapping[str, Value], scratch: Path) -> None:
        self.name = name
        self._report_file = scratch / f"{name}.report.json"
        self._output = scratch / f"{name}.output"
        parameters = scratch / f"{name}.parameters.yaml"
        own = {"parent_process": os.getpid(), "report_file": str(self._report_file)}
        parameters.write_text(json.dumps({"/**": {"ros__parameters": {**values, **own}}}), encoding="utf-8")
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(filter(None, (str(_IMPORT_FOLDER), os.environ.get("PYTHONPATH", "")))),
        }
        command = [sys.executable, "-m", f"flexros_nodes.{name}", "--ros-args", "--params-file", str(parameters)]
        with self._output.open("wb") as output:
            self._process = subprocess.Popen(  # noqa: S603 - our own module with our own arguments
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
        self._asked_to_stop = False

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """Whether the process is over."""
        return self._process.poll() is not None

    @property
    def killed(self) -> bool:
        """Whether a signal has ended the process."""
        return (self._process.poll() or 0) < 0

    def report(self) -> NodeReport | None:
        """Give the report that the node left; of one that refused to begin, what it printed; else None."""
        if (report := read_report(self._report_file)) is not None:
            return report
        code, lines = self._process.poll(), self._last_lines()
        if code in (InputError.exit_code, RunError.exit_code) and lines and lines[-1].startswith(ERROR_PREFIX):
            return NodeReport(self.name, code, lines[-1].removeprefix(ERROR_PREFIX))
        return None

    def _last_lines(self) -> list[str]:
        return self._output.read_text(encoding="utf-8", errors="replace").strip().splitlines()[-_LAST_LINES:]

    def death(self) -> str:
        """Say how the process died, nothing if it ended with a report or because it was asked to."""
        code = self._process.poll()
        if code is None or self.report() is not None or (self._asked_to_stop and code == -signal.SIGTERM):
            return ""
        how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        lines = self._last_lines()
        said = f", its last words: {' | '.join(lines)}" if lines and code > 0 else ""
        return f"the process of node {self.name} {how}{said}"

    def ask_to_stop(self) -> None:
        """Tell the process to shut its node down, without waiting for it.

        By SIGTERM, because a process that a shell started in the background has its children ignore SIGINT too.
        """
        if not self.ended:
            self._asked_to_stop = True
            self._process.send_signal(signal.SIGTERM)

    def tell_partner_ended(self) -> None:
        """Tell a node at work that another one of the run has ended."""
        if not self.ended:
            self._process.send_signal(PARTNER_ENDED)

    def stop(self, timeout: float) -> None:
        """End the process: ask, and after a time-out [s] make it."""
        self.ask_to_stop()
        if not self.ended:
            try:
                self._process.wait(timeout)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self._process.wait()
