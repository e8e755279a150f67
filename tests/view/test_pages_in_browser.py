"""What Chromium draws of the pages: the arm in its colour, moved by time and magnification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.robot import load_robot
from tests.browser import Browser, opened_browser, wait

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from flexros.view.player import LogPlayer

pytest.importorskip("viser", reason="the viewer is not installed: pip install 'flexros[view]'")
pytestmark = pytest.mark.slow
PORT = 18430
SCENE = 510
"""Width of the scene, left of the panel [px]."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with opened_browser() as one:
        one.size(900, 420)  # without a graphics card every pixel costs time
        yield one


@pytest.fixture(scope="module")
def player(circle: Path, browser: Browser) -> Iterator[LogPlayer]:
    from flexros.view.player import LogPlayer
    from flexros.view.shown import shown_log

    page = LogPlayer(shown_log(circle), port=PORT)
    try:
        page._playing.value = False
        browser.open(page.address)
        wait(lambda: blue(browser).sum() > 400, 60, "the arm to be drawn")
        yield page
    finally:
        page.stop()


def blue(browser: Browser) -> np.ndarray:
    """Pixels of the scene in the colour of the arm: much more blue than red, shape (height, SCENE)."""
    picture = browser.picture()[:, :SCENE].astype(int)
    picture[:160, :330] = 255  # a notice about software rendering
    return (picture[:, :, 2] - picture[:, :, 0] > 60) & (picture[:, :, 1] > picture[:, :, 0])


def orange(browser: Browser) -> int:
    """Number of pixels of the scene in the colour of the ribbon."""
    picture = browser.picture()[:, :SCENE].astype(int)
    picture[:160, :330] = 255
    return int(((picture[:, :, 0] - picture[:, :, 2] > 60) & (picture[:, :, 0] > 150)).sum())


def moved(browser: Browser, before: np.ndarray) -> bool:
    now = blue(browser)
    return bool((now ^ before).sum() > 0.05 * before.sum())


def test_arm_is_drawn_where_the_robot_is(player: LogPlayer, browser: Browser) -> None:
    rows, columns = np.nonzero(blue(browser))
    assert np.ptp(columns) > 2 * np.ptp(rows) > 0, "the arm of this robot is stretched out along x"
    assert 10 < columns.min() < columns.max() < SCENE - 10, "and wholly in view"
    assert browser.messages == []


def test_magnified_deflection_moves_the_arm(player: LogPlayer, browser: Browser) -> None:
    player.show(8)
    before = blue(browser)
    player._deflection.value = 3
    wait(lambda: moved(browser, before), 60, "the arm to be bent")


def test_plots_are_drawn_on_one_axis_of_time(player: LogPlayer, browser: Browser) -> None:
    titles = browser.value("[...document.querySelectorAll('.u-title')].map(e => e.textContent)")
    assert titles[:2] == ["path error [mm]", "deflection [mrad]"]
    widths = browser.value("[...document.querySelectorAll('.u-over')].map(e => e.getBoundingClientRect().width)")
    assert min(widths) > 100


def test_ribbon_of_the_path_error_is_drawn(player: LogPlayer, browser: Browser) -> None:
    before = orange(browser)
    player._look("path")
    wait(lambda: orange(browser) > 5 * before + 200, 60, "the ribbon in view")


def test_robot_page_moves_with_its_sliders(browser: Browser) -> None:
    from flexros.view.robot_page import RobotPage

    page = RobotPage(load_robot("six_axis"), port=PORT)
    try:
        browser.open(page.address)
        wait(lambda: blue(browser).sum() > 400, 60, "the robot to be drawn")
        before = blue(browser)
        page._motors[1].value = 1.2
        wait(lambda: moved(browser, before), 60, "the robot in another pose")
    finally:
        page.stop()
