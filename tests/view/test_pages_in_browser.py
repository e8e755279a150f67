"""What Chromium draws of the pages: the arm in its colour, moved by time and magnification."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf
from tests.browser import Browser, opened_browser, wait

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flexros.view.player import LogPlayer
    from flexros.view.robot_page import RobotPage

pytest.importorskip("viser", reason="the viewer is not installed: pip install 'flexros[view]'")
pytestmark = pytest.mark.slow
PORT = 18430
URDF = Path(__file__).parents[2] / "docs/examples/ur5e.urdf"
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
        show(page, browser)
        seen(lambda: blue(browser).sum() > 400, "the arm to be drawn")
        yield page
    finally:
        stop(page, browser)


def show(page: LogPlayer | RobotPage, browser: Browser) -> None:
    """Open a page without its notice about software rendering, which covers a part of the scene."""
    browser.open(page.address)
    browser.value(
        "document.head.insertAdjacentHTML('beforeend', '<style>.mantine-Notification-root{display:none}</style>')"
    )


def stop(page: LogPlayer | RobotPage, browser: Browser) -> None:
    """End a page that nobody looks at: one whose server goes away is drawn anew, which costs 4 s of a processor."""
    browser.open("about:blank")
    page.stop()


def seen(holds: Callable[[], bool], what: str) -> None:
    """Wait until pictures show it; a picture costs as much as one that the page draws."""
    wait(holds, 60, what, pause=0.25)


def blue(browser: Browser) -> np.ndarray:
    """Pixels of the scene in the colour of the arm: much more blue than red, shape (height, SCENE)."""
    picture = browser.picture()[:, :SCENE].astype(int)
    return (picture[:, :, 2] - picture[:, :, 0] > 60) & (picture[:, :, 1] > picture[:, :, 0])


def orange(browser: Browser) -> int:
    """Number of pixels of the scene in the colour of the ribbon."""
    picture = browser.picture()[:, :SCENE].astype(int)
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
    seen(lambda: moved(browser, before), "the arm to be bent")


def test_arm_moves_by_itself(player: LogPlayer, browser: Browser) -> None:
    before = blue(browser)
    player._playing.value = True
    try:
        seen(lambda: moved(browser, before), "the arm to move")
    finally:
        player._playing.value = False
        player.show(8)


def test_plots_are_drawn_on_one_axis_of_time(player: LogPlayer, browser: Browser) -> None:
    titles = browser.value("[...document.querySelectorAll('.u-title')].map(e => e.textContent)")
    assert titles[:2] == ["path error [mm]", "deflection [mrad]"]
    widths = browser.value("[...document.querySelectorAll('.u-over')].map(e => e.getBoundingClientRect().width)")
    assert min(widths) > 100


def test_ribbon_of_the_path_error_is_drawn(player: LogPlayer, browser: Browser) -> None:
    before = orange(browser)
    player._look("path")
    seen(lambda: orange(browser) > 5 * before + 200, "the ribbon in view")


def test_robot_page_moves_with_its_sliders(browser: Browser) -> None:
    from flexros.view.robot_page import RobotPage

    page = RobotPage(load_robot("six_axis"), port=PORT)
    try:
        show(page, browser)
        seen(lambda: blue(browser).sum() > 400, "the robot to be drawn")
        before = blue(browser)
        page._motors[1].value = 1.2
        seen(lambda: moved(browser, before), "the robot in another pose")
    finally:
        stop(page, browser)


def test_links_of_a_urdf_are_drawn(browser: Browser, tmp_path: Path) -> None:
    from flexros.view.robot_page import RobotPage

    file = tmp_path / "ur5e.yaml"
    file.write_text(robot_from_urdf(URDF, folder=tmp_path).text)
    page = RobotPage(load_robot(file), port=PORT)
    surfaces = blue_of(page, browser)
    page._motors[1].value = -1.2
    seen(lambda: moved(browser, surfaces), "the links in another pose")
    stop(page, browser)
    file.write_text("".join(line for line in file.read_text().splitlines(True) if not line.startswith("drawing:")))
    page = RobotPage(load_robot(file), port=PORT)
    bars = blue_of(page, browser)
    stop(page, browser)
    assert surfaces.sum() > 1.3 * bars.sum(), "links are thicker than bars"


def blue_of(page: RobotPage, browser: Browser) -> np.ndarray:
    show(page, browser)
    pictures = [blue(browser)]

    def at_rest() -> bool:
        pictures.append(blue(browser))
        return (
            bool(pictures[-1].sum() > 400)
            and len(pictures) > 4
            and all((one == pictures[-1]).all() for one in pictures[-5:])
        )

    seen(at_rest, "the whole robot to be drawn")  # links are loaded one by one
    return pictures[-1]


def test_phone_has_the_arm_above_a_panel_of_its_width(circle: Path, browser: Browser) -> None:
    from flexros.view.player import LogPlayer
    from flexros.view.shown import shown_log

    page = LogPlayer(shown_log(circle), port=PORT + 1)
    try:
        page._playing.value = False
        browser.size(390, 700)
        show(page, browser)
        browser.until("document.querySelectorAll('.u-over').length > 2", 60)
        box = browser.value(
            "(r => [r.left, r.top, r.width, r.height])"
            "(document.querySelector('.mantine-Paper-root[style*=\"bottom: 0px\"]').getBoundingClientRect())"
        )
        assert box[0] == 0
        assert box[2] == 390
        assert box[3] <= 0.5 * 700 + 1
        narrowest = "Math.min(...[...document.querySelectorAll('.u-over')].map(e => e.getBoundingClientRect().width))"
        browser.until(f"{narrowest} > 0", 60)  # plots are laid out after they are there
        assert browser.value(narrowest) > 250, "plots use the width"

        def in_view() -> bool:
            columns = np.nonzero(blue_above(browser, box[1]))[1]
            return len(columns) > 400 and bool(5 < columns.min() < columns.max() < 385)

        seen(in_view, "the arm above the panel, wholly in view once the camera has taken its place")
        assert browser.value("document.documentElement.scrollWidth") == 390
    finally:
        stop(page, browser)
        browser.size(900, 420)


def blue_above(browser: Browser, top: float) -> np.ndarray:
    picture = browser.picture()[: int(top)].astype(int)
    return (picture[:, :, 2] - picture[:, :, 0] > 60) & (picture[:, :, 1] > picture[:, :, 0])
