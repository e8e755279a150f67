from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.logs.reader import read_log
from flexros.report.base import Picture
from flexros.report.page import page_html
from flexros.view.animation import FRAMES, motion_chapter
from tests.browser import opened_browser

if TYPE_CHECKING:
    from pathlib import Path


def test_arm_of_the_report_ends_at_the_tool(circle: Path) -> None:
    log = read_log(circle)
    picture = motion_chapter(log, load_model("e12"), "circle").blocks[0]
    assert isinstance(picture, Picture)
    line = picture.moving
    assert line is not None
    assert len(line.time) <= FRAMES
    assert log.tool_pose is not None
    rows = np.round(line.time / 5e-4).astype(int)
    tool = line.base[:, -1] + line.deviation[:, -1]
    assert np.abs(tool - log.tool_pose.position[rows]).max() < 2e-4


def test_commanded_path_is_drawn_where_it_is_given(circle: Path) -> None:
    log = read_log(circle)
    assert log.tool_reference is not None
    given = (None, log.tool_reference.position)
    pictures = [motion_chapter(log, load_model("e12"), "circle", path).blocks[0] for path in given]
    names = [[trace.name for trace in picture.figure.data] for picture in pictures]
    assert names[1] == [*names[0], "commanded path"]


@pytest.mark.slow
def test_page_plays_the_arm_offline_and_stays_small(circle: Path, tmp_path: Path) -> None:
    chapter = motion_chapter(read_log(circle), load_model("e12"), "circle")
    file = tmp_path / "page.html"
    file.write_text(page_html("Arm", "s", [chapter], packed=True))
    bare = page_html("Arm", "s", [type(chapter)("c", (Picture(chapter.blocks[0].figure, "c"),))], packed=True)
    assert len(file.read_text()) - len(bare) < 150_000
    with opened_browser() as browser:
        browser.size(800, 600)
        browser.open(file)
        tip = "document.getElementById('picture-1').data[1].z.slice(-1)[0]"
        browser.until("document.getElementById('picture-1').data !== undefined", 60)
        first = browser.value(tip)
        browser.value("document.getElementById('picture-1-play').click()")
        browser.until(f"Math.abs({tip} - {first}) > 1e-3", 60)
        assert browser.value("document.getElementById('picture-1-play').textContent") == "Pause"
        browser.value("document.getElementById('picture-1-play').click()")
        slider = "document.getElementById('picture-1-slider')"
        before = browser.value(tip)
        browser.value(f"{slider}.value = 4; {slider}.dispatchEvent(new Event('input'))")
        browser.until(f"Math.abs({tip} - {before}) > 1e-3", 60)
        assert browser.messages == []
