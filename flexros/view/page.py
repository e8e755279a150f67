"""A page of the viewer: its address, its thread and its end."""

from __future__ import annotations

import contextlib
import io
import threading
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable


class AbstractPage:
    """A page in the browser that a thread moves.

    Args:
        title: Title of the page.
        host: Address the page listens on.
        port: Port; the next free one is taken where it is in use.

    Attributes:
        server: The viser page.

    Raises:
        InputError: viser is not installed.
    """

    def __init__(self, title: str, host: str, port: int) -> None:
        self.server = new_server(title, host, port)
        self._lock, self._ended = threading.RLock(), threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def stop(self) -> None:
        """End motion and page."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join(2.0)
        self.server.stop()

    def _move(self, work: Callable[[], None]) -> None:
        """Start the thread that moves the page."""
        self._thread = threading.Thread(target=work, name="flexros view", daemon=True)
        self._thread.start()


def check_viewer() -> None:
    """Raise an `InputError` where viser is not installed."""
    if find_spec("viser") is None:
        raise InputError("the viewer needs the package viser; install it with: pip install 'flexros[view]'")


def new_server(title: str, host: str, port: int) -> Any:
    """Start a viewer page.

    Args:
        title: Title of the panel.
        host: Address it listens on.
        port: Port; the next free one is taken where it is in use.

    Returns:
        The `viser.ViserServer`.

    Raises:
        InputError: viser is not installed.
    """
    check_viewer()
    import viser

    with contextlib.redirect_stdout(io.StringIO()):  # it prints addresses of its own
        server = viser.ViserServer(host=host, port=port, label="FlexROS", verbose=False)
    server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
    server.gui.set_panel_label(title)
    server.gui.main_panel.dock_right()
    server.scene.world_axes.visible = False
    return server
