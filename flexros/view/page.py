"""A page of the viewer: its address, its thread and its end."""

from __future__ import annotations

import contextlib
import io
import threading
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray

PHONE = 600
"""Windows narrower than this have the panel below the scene [px], as viser does."""
_PHONE_STYLE = """<style>@media (max-width: 600px) {
.mantine-Paper-root[style*="bottom: 0px"] { width: 100% !important; max-height: 50% !important }
.mantine-Paper-root[style*="bottom: 0px"] [style="width: 20em;"] { width: 100% !important }
}</style>"""
"""The panel of a narrow window: as wide as the window and not over the upper half, where the arm is."""
_SKY = 2.0
"""Intensity of the light from the sky (chosen: arms are as bright as with viser's surroundings)."""
_GROUND = (160, 165, 175)
"""Colour of the light from the ground (chosen: no side of an arm is black)."""
_LEAST_SCENE = 100
"""Width and height below which a scene is not laid out yet [px] (chosen: no phone is that small)."""
FLOOR_BELOW = 0.02
"""Distance of the floor below the arm at rest, relative to its size [1] (chosen)."""
_WIDE = 1.1
"""Ratio of width to height of the scene beside the panel for which distances of the camera are chosen [1]."""


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

    def _aim(self, target: FloatArray, away: FloatArray) -> None:
        """Set where the camera is at first, and where it is kept on phones.

        Args:
            target: Point that is looked at [m], shape (3,).
            away: From there to the camera, in a wide window [m], shape (3,).
        """
        camera = self.server.initial_camera
        camera.position, camera.look_at = tuple(target + away), tuple(target)
        self.server.on_client_connect(lambda client: self._keep_in_view(client, target, away))

    def _keep_in_view(self, client: Any, target: FloatArray, away: FloatArray) -> None:
        """Aim the camera of a narrow window, and again for as long as it is nowhere that its reader has moved it to.

        A window takes the place of a wide one when it draws its first picture, also after it has been aimed; and its
        first messages may tell of a scene that is not laid out yet, 2 px wide. So each message is looked at. Where a
        narrow scene is seen from the place of a wide one, or a scene has changed its size and is still seen from where
        it was aimed last, it is aimed anew.
        """
        aimed: list[tuple[Any, Any]] = []

        def look(camera: Any) -> None:
            with self._lock:
                size, place = (camera.image_width, camera.image_height), (camera.position, camera.look_at)
                if min(size) < _LEAST_SCENE:
                    return
                new = not aimed or np.allclose(place, (target + away, target), atol=1e-6)
                resized = bool(aimed) and size != aimed[0][0] and np.allclose(place, aimed[0][1], atol=1e-6)
                if resized or (new and _narrow(camera)):
                    self._aim_one(client, target, away)
                    aimed[:] = [(size, (camera.position, camera.look_at))]

        client.camera.on_update(look)
        look(client.camera)

    def _aim_one(self, client: Any, target: FloatArray, away: FloatArray) -> None:
        """Turn the camera of one window; in a narrow one further off, with the target in the upper half."""
        camera = client.camera
        if _narrow(camera):
            away = away * max(1.0, _WIDE / camera.aspect)
            drop = 0.5 * float(np.linalg.norm(away)) * float(np.tan(0.5 * camera.fov))
            target = target - np.array([0.0, 0.0, drop])
        with client.atomic():
            camera.position, camera.look_at = tuple(target + away), tuple(target)

    def _move(self, work: Callable[[], None]) -> None:
        """Start the thread that moves the page."""
        self._thread = threading.Thread(target=work, name="flexros view", daemon=True)
        self._thread.start()


def _narrow(camera: Any) -> bool:
    """Return whether a scene is that of a phone, and not one beside the panel of a wide window."""
    return bool(camera.image_width < min(PHONE, camera.image_height))


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
    server.gui.add_html(_PHONE_STYLE)
    server.scene.world_axes.visible = False
    _light(server.scene)
    return server


def _light(scene: Any) -> None:
    """Light the scene from the sky and, weaker, from the ground, without reflections of surroundings.

    Reflections cost three quarters of the time to the first picture on a machine without a graphics card.
    """
    scene.configure_environment_map(hdri=None)
    scene.configure_default_lights(cast_shadow=False)  # nothing casts one
    scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=_GROUND, intensity=_SKY)
