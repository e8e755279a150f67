"""Where the cameras of windows are aimed, as messages of their state arrive."""

from __future__ import annotations

import contextlib
import threading
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.view.page import AbstractPage

if TYPE_CHECKING:
    from collections.abc import Callable

TARGET, AWAY = np.array([1.0, 0.0, -0.2]), np.array([0.2, -2.0, 0.4])
WIDE = (TARGET + AWAY, TARGET)
MOVED = (np.array([2.0, 1.0, 1.0]), np.zeros(3))


class Window:
    """A window whose camera has a place and the size of its scene [px]."""

    atomic = contextlib.nullcontext

    def __init__(self, width: int, height: int) -> None:
        self.told: list[Callable[[Any], None]] = []
        self.camera = SimpleNamespace(
            image_width=width, image_height=height, fov=0.8, aspect=width / height,
            position=WIDE[0], look_at=WIDE[1], on_update=self.told.append,
        )  # fmt: skip

    def tell(self, place: tuple[np.ndarray, np.ndarray] | None = None, width: int = 0, height: int = 0) -> None:
        """Send a message with what has changed."""
        camera = self.camera
        if place is not None:
            camera.position, camera.look_at = place
        if width:
            camera.image_width, camera.image_height, camera.aspect = width, height, width / height
        for look in self.told:
            look(camera)

    def place(self) -> np.ndarray:
        return np.array([self.camera.position, self.camera.look_at])

    def distance(self) -> float:
        return float(np.linalg.norm(np.subtract(*self.place())))


def opened(width: int, height: int) -> Window:
    """Open a window at a page, which aims its camera."""
    page: Any = SimpleNamespace(_lock=threading.RLock())
    page._aim_one = lambda *given: AbstractPage._aim_one(page, *given)
    window = Window(width, height)
    AbstractPage._keep_in_view(page, window, TARGET, AWAY)
    return window


def test_a_phone_is_aimed_again_after_its_first_picture_has_moved_its_camera() -> None:
    window = opened(390, 700)
    aimed = window.place()
    assert window.distance() > 1.5 * np.linalg.norm(AWAY)
    window.tell(WIDE)
    np.testing.assert_allclose(window.place(), aimed)


def test_a_scene_that_is_not_laid_out_yet_is_not_aimed() -> None:
    window = opened(2, 700)
    np.testing.assert_array_equal(window.place(), WIDE)
    window.tell(width=390, height=700)
    np.testing.assert_allclose(window.place(), opened(390, 700).place())


def test_a_phone_that_is_turned_is_aimed_again() -> None:
    window = opened(390, 700)
    window.tell(width=700, height=390)
    np.testing.assert_allclose(window.place(), WIDE)


@pytest.mark.parametrize("size", [(390, 700), (640, 400)], ids=["the same size", "turned"])
def test_a_camera_that_its_reader_has_moved_stays(size: tuple[int, int]) -> None:
    window = opened(390, 700)
    window.tell(MOVED, *size)
    np.testing.assert_array_equal(window.place(), MOVED)


@pytest.mark.parametrize("size", [(1280, 720), (512, 420)], ids=["whole window", "beside the panel"])
def test_a_wide_window_stays_where_it_begins(size: tuple[int, int]) -> None:
    np.testing.assert_array_equal(opened(*size).place(), WIDE)
