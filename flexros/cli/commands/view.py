"""Command that shows an arm in the browser."""

from __future__ import annotations

import re
import subprocess
import sys
import time
import webbrowser
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexros.cli.options import NamespaceOption
from flexros.cli.output import say
from flexros.cli.progress import progress_shown
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.view.player import LogPlayer
    from flexros.view.robot_page import RobotPage


TOPICS = "topics"
"""What is given for a running robot."""
LONGEST_END = 5.0
"""Wait for the end of the live page of a run [s] (chosen)."""
_PROGRAM = "from flexros.cli import main; main()"
GROUP = "flexros.view"
"""Entry points that listen to a running robot; the package of the nodes registers "ros"."""


def view(
    what: str = typer.Argument(
        help="A log (rosbag2 folder, .mcap or .db3 file), the folder of a diagnosis, a robot (its name or file, a "
        "patch), or the word topics for a running robot."
    ),
    model: str = typer.Option(
        "", "--model", help="Robot of the log or nominal model of the diagnosis; default: from its provenance."
    ),
    log: Path = typer.Option(None, "--log", help="Log of a diagnosis; default: looked for beside its folder."),
    first: float = typer.Option(0.0, "--from", help="Beginning of the part of a log that is shown [s]."),
    length: float = typer.Option(60.0, "--length", help="Length of that part [s]."),
    magnification: int = typer.Option(None, "--magnification", min=1, help="Of the deflection at first."),
    host: str = typer.Option("127.0.0.1", "--host", help="Address the page listens on; 0.0.0.0 for other machines."),
    port: int = typer.Option(8080, "--port", help="Port; the next free one is taken where it is in use."),
    namespace: NamespaceOption = "",
    browser: bool = typer.Option(True, "--browser/--no-browser", help="Open the page in the browser."),
) -> None:
    """Show a log, a robot or a diagnosis as a moving arm in the browser; Ctrl-C ends."""
    from flexros.view.shown import is_diagnosis, is_log, shown_diagnosis, shown_log

    require_viewer()
    if what == TOPICS:
        live(model, namespace, host, port, browser)
        return
    path = Path(what)
    with progress_shown() as show:
        if is_diagnosis(path):
            show("diagnosis", 0.0)
            shown = shown_diagnosis(path, log, model, first=first, length=length, progress=show)
        elif is_log(path):
            show("motion of the robot", 0.0)
            shown = shown_log(path, model, namespace=namespace, first=first, length=length)
        else:
            shown = None
    page: LogPlayer | RobotPage
    if shown is None:
        from flexros.effects.patching.patched_robot import load_model
        from flexros.view.robot_page import RobotPage

        page = RobotPage(load_model(what).robot, host=host, port=port)
    else:
        from flexros.view.player import LogPlayer

        page = LogPlayer(shown, host=host, port=port, factor=magnification)
    serve(page, browser)


def live(model: str, namespace: str, host: str, port: int, browser: bool) -> None:
    """Show a running robot until Ctrl-C.

    Args:
        model: Its robot name, robot file or patch.
        namespace: Namespace of its topics.
        host: Address the page listens on.
        port: Port of the page.
        browser: Whether to open it.

    Raises:
        InputError: No robot was given, or ROS 2 is not installed.
    """
    from flexros.effects.patching.patched_robot import load_model
    from flexros.view.live import LivePage

    if not model:
        raise InputError("no robot was given for the topics; give its name or file", argument="model")
    source = next(iter(metadata.entry_points(group=GROUP)), None)
    if source is None or find_spec("rclpy") is None:
        raise InputError("topics need ROS 2, which is not installed here: source it, or install the extra ros")
    listen = source.load()
    page = LivePage(load_model(model).robot, host=host, port=port)
    say(f"Open {page.address} in a browser; Ctrl-C ends.")
    try:
        if browser:
            webbrowser.open(page.address)
        listen(page, namespace=namespace)
    finally:
        page.stop()


def require_viewer() -> None:
    """Fail before a long run where the viewer is not installed.

    Raises:
        InputError: viser is missing.
    """
    from flexros.view.page import check_viewer

    check_viewer()


class PageBeside:
    """The live page of a run, in a process of its own, so that the run is not slowed.

    It is entered where the ROS domain of the run is in the environment.

    Args:
        model: Robot of the run.

    Attributes:
        port: Port of the page; None before it was opened, and where it could not be.
    """

    def __init__(self, model: str) -> None:
        self._command = [sys.executable, "-c", _PROGRAM, "view", TOPICS, "--model", model]
        self._process: subprocess.Popen[str] | None = None
        self.port: int | None = None

    def __enter__(self) -> PageBeside:
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE, text=True)  # noqa: S603 - no shell
        assert self._process.stdout is not None
        line = self._process.stdout.readline().strip()  # it is printed as soon as the page listens
        found = re.search(r"http://\S+:(\d+)", line)
        if found:
            self.port = int(found[1])
            typer.echo(f"flexros: {found[0]} shows the run", err=True)
        return self

    def __exit__(self, *_: object) -> None:
        process = self._process
        assert process is not None
        process.terminate()
        try:
            process.wait(LONGEST_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()


def show_log(path: Path, port: int | None = None) -> None:
    """Show a log in the browser until Ctrl-C.

    Args:
        path: The log.
        port: Port of a page that is open in the browser and turns to this one; None to open a page.
    """
    from flexros.view.player import LogPlayer
    from flexros.view.shown import shown_log

    with progress_shown() as show:
        show("motion of the robot", 0.0)
        shown = shown_log(path)
    serve(LogPlayer(shown) if port is None else LogPlayer(shown, port=port), browser=port is None)


def serve(page: LogPlayer | RobotPage, browser: bool) -> None:
    """Tell the address of a page, open it, and wait until Ctrl-C."""
    say(f"Open {page.address} in a browser; Ctrl-C ends.")
    try:
        if browser:
            webbrowser.open(page.address)
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        pass
    finally:
        page.stop()
