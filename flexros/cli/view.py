"""Command that shows an arm in the browser."""

from __future__ import annotations

import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexros.cli.options import NamespaceOption
from flexros.cli.output import say
from flexros.cli.progress import progress_shown

if TYPE_CHECKING:
    from flexros.view.player import LogPlayer
    from flexros.view.robot_page import RobotPage


def view(
    what: str = typer.Argument(
        help="A log (rosbag2 folder or .mcap file), the folder of a diagnosis, or a robot: its name or file, a patch."
    ),
    model: str = typer.Option("", "--model", help="Robot of the log; default: from its provenance."),
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
    path = Path(what)
    with progress_shown() as show:
        if is_diagnosis(path):
            show("diagnosis", 0.0)
            shown = shown_diagnosis(path, log, first=first, length=length, progress=show)
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


def require_viewer() -> None:
    """Fail before a long run where the viewer is not installed.

    Raises:
        InputError: viser is missing.
    """
    from flexros.view.scene import check_viewer

    check_viewer()


def show_log(path: Path) -> None:
    """Show a log in the browser until Ctrl-C."""
    from flexros.view.player import LogPlayer
    from flexros.view.shown import shown_log

    with progress_shown() as show:
        show("motion of the robot", 0.0)
        shown = shown_log(path)
    serve(LogPlayer(shown), browser=True)


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
