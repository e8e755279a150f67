"""A node as a child process: start, supervision and stop."""

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
    """Node in a child process, which does not outlive this process.

    The child has its own process group, so that Ctrl-C in the terminal reaches only the parent and the nodes are shut
    down in order.

    Args:
        name: Name of the node.
        values: Parameter values.
        scratch: Folder for the parameter file, the report and the output of the node.
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
        self._stop_requested = False

    @property
    def pid(self) -> int:
        """Process identifier."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    @property
    def killed(self) -> bool:
        """Whether a signal ended the process."""
        return (self._process.poll() or 0) < 0

    def report(self) -> NodeReport | None:
        """Return the report of the node; if it ended during its start, a report of what it printed; else None."""
        if (report := read_report(self._report_file)) is not None:
            return report
        code, lines = self._process.poll(), self._last_lines()
        if code in (InputError.exit_code, RunError.exit_code) and lines and lines[-1].startswith(ERROR_PREFIX):
            return NodeReport(self.name, code, lines[-1].removeprefix(ERROR_PREFIX))
        return None

    def _last_lines(self) -> list[str]:
        return self._output.read_text(encoding="utf-8", errors="replace").strip().splitlines()[-_LAST_LINES:]

    def death(self) -> str:
        """Return how the process died; empty if it ended with a report or on request."""
        code = self._process.poll()
        if code is None or self.report() is not None or (self._stop_requested and code == -signal.SIGTERM):
            return ""
        how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        lines = self._last_lines()
        output = f", its last output: {' | '.join(lines)}" if lines and code > 0 else ""
        return f"the process of node {self.name} {how}{output}"

    def request_stop(self) -> None:
        """Request the shutdown of the node, without waiting for it.

        The signal is SIGTERM, because children of a background process of a shell ignore SIGINT.
        """
        if not self.ended:
            self._stop_requested = True
            self._process.send_signal(signal.SIGTERM)

    def report_partner_ended(self) -> None:
        """Inform the node that another node of the run has exited."""
        if not self.ended:
            self._process.send_signal(PARTNER_ENDED)

    def wait(self, timeout: float) -> None:
        """Wait for the end of the process, at most a time-out [s]."""
        self._process.wait(timeout)

    def stop(self, timeout: float) -> None:
        """Stop the process: by request, after a time-out [s] by SIGKILL."""
        self.request_stop()
        if not self.ended:
            try:
                self._process.wait(timeout)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self._process.wait()
