"""A page of the report kit in Chromium: widths, folded pictures, dark colours."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.gap.report.ranking import _bars
from flexros.gap.report.waterfall import waterfall_figure
from flexros.gap.report.where import _spectrum
from flexros.gap.schema import Diagnosis, Excess, GapNumbers, Step, Waterfall
from flexros.report.base import Folded, Paragraph, Picture, TextTable
from flexros.report.colours import DARK
from flexros.report.page import Chapter, page_html
from flexros.report.theme import curve, stacked
from tests.browser import Browser, opened_browser

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.slow
BLUE = "#0072b2"


def picture() -> Picture:
    x = np.linspace(0.0, 1.0, 50)
    figure = stacked(["A title that is far too long for the width of a phone", "b", "c", "d"], columns=2)
    for place in range(4):
        line = curve(x, np.sin(9 * x), "sine", BLUE, hover="", width=4.0)
        figure.add_trace(line, row=place // 2 + 1, col=place % 2 + 1)
    return Picture(figure, "Four panels.")


def bars() -> Picture:
    import plotly.graph_objects as go

    figure = stacked([""], height=120)
    figure.add_trace(
        go.Bar(x=[1, 2], y=["Coulomb friction at motor_1", "Viscous friction at motor_2"], orientation="h")
    )
    figure.update_layout(margin={"l": 290})
    return Picture(figure, "Two bars.")


def cells() -> Picture:
    import plotly.graph_objects as go

    figure = stacked([""], height=120)
    names = [f"gear torque<br>reversal {place}" for place in range(11)]
    figure.add_trace(go.Heatmap(z=[list(range(11))], x=names, y=["motor_1"], showscale=False))
    return Picture(figure, "Eleven cells.")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    wide = TextTable(tuple("abcdefgh"), (("a long name with words", *["1234567.89"] * 7),), "Wide.")
    names = TextTable(("Entry", "Value"), (("recorded.joint_commands.messages_that_were_missing", "x" * 90),), "Names.")
    prose = TextTable(
        ("a", "b", "c", "d"), (("one", "two", "many words in a cell that nobody reads in ten lines", "1"),), "P.", 3
    )
    chapters = [Chapter("One", (picture(), wide)), Chapter("Two", (Folded("more", (picture(), names)),))]
    file: Path = tmp_path_factory.mktemp("page") / "page.html"
    file.write_text(
        page_html("Title", "s", [*chapters, Chapter("Three", (Paragraph("p"), bars(), prose, cells()))], packed=True)
    )
    with opened_browser() as one:
        one.open(file)
        one.until("document.querySelector('#picture-1 .main-svg') !== null")
        yield one


def painted(browser: Browser, colour: str) -> int:
    """Number of pixels of the window near a colour."""
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return int((np.abs(browser.picture().astype(int) - wanted).max(axis=2) < 24).sum())


@pytest.mark.parametrize("width", [390, 1366])
def test_page_is_not_wider_than_the_screen(browser: Browser, width: int) -> None:
    browser.size(width, 800)
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.messages == []


def test_contents_stand_beside_the_text_where_there_is_room(browser: Browser) -> None:
    place = "document.querySelector('%s').getBoundingClientRect().%s"
    browser.size(1366, 768)
    assert browser.value(place % ("nav", "right")) <= browser.value(place % ("main", "left")) + 1
    browser.size(390, 800)
    assert browser.value(place % ("nav", "bottom")) <= browser.value(place % ("main", "top")) + 1


def test_panels_stand_below_each_other_on_a_phone(browser: Browser) -> None:
    starts = "['xaxis','xaxis2','xaxis3','xaxis4'].map(a => document.getElementById('picture-1').layout[a].domain[0])"
    browser.size(1366, 768)
    browser.until(f"new Set({starts}).size === 2")
    browser.size(390, 800)
    browser.until(f"new Set({starts}).size === 1")
    assert "<br>" in browser.value("document.getElementById('picture-1').layout.annotations[0].text")
    heights = browser.value("['yaxis','yaxis2','yaxis3','yaxis4'].map(a => " \
        "document.getElementById('picture-1').layout[a].domain)")  # fmt: skip
    assert all(above[0] > below[1] for above, below in itertools.pairwise(heights))


@pytest.mark.parametrize("width", [390, 1366])
def test_names_of_bars_are_whole(browser: Browser, width: int) -> None:
    browser.size(width, 800)
    browser.until("document.querySelectorAll('#picture-3 .ytick text').length === 2")
    edges = browser.value(
        "[...document.querySelectorAll('#picture-3 .ytick text')].map(e => e.getBoundingClientRect().left"
        " - document.querySelector('#picture-3').getBoundingClientRect().left)"
    )
    assert min(edges) >= 0
    words = browser.value("[...document.querySelectorAll('#picture-3 .ytick text')].map(e => e.textContent).join()")
    assert "motor_1" in words
    assert "Viscous" in words


def test_colours_follow_the_preference_of_the_reader(browser: Browser) -> None:
    browser.size(1366, 768)
    browser.until("document.getElementById('picture-1').layout.paper_bgcolor === '#ffffff'")
    light = painted(browser, "#ffffff"), painted(browser, BLUE)
    browser.size(1366, 768, dark=True)
    browser.until(f"document.getElementById('picture-1').layout.paper_bgcolor === '{DARK['#ffffff']}'")
    assert painted(browser, "#ffffff") < 0.01 * light[0]
    assert painted(browser, DARK["#ffffff"]) > 0.5 * light[0]
    assert painted(browser, DARK[BLUE]) > 0.5 * light[1] > 500
    browser.size(1366, 768)


def test_folded_picture_is_drawn_when_it_is_opened(browser: Browser) -> None:
    browser.size(1366, 768)
    assert browser.value("document.querySelector('#picture-2 .main-svg')") is None
    browser.value("document.querySelector('details').open = true")
    browser.until("document.querySelector('#picture-2 .main-svg') !== null")
    assert browser.value("document.getElementById('picture-2').clientWidth") > 600


def test_on_paper_two_pictures_share_a_page_and_tables_are_whole(browser: Browser) -> None:
    browser.size(1366, 768)
    height = "document.getElementById('picture-1').layout.height"
    browser.until(f"{height} > 420")
    screen = browser.value(height)
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.value("window.dispatchEvent(new Event('beforeprint'))")
    browser.until(f"{height} === 420")
    table = browser.value("document.querySelector('table').getBoundingClientRect().width")
    assert table <= browser.value("document.querySelector('main').clientWidth") <= 690
    assert browser.value("getComputedStyle(document.querySelector('figure.table')).breakInside") == "auto"
    browser.call("Emulation.setEmulatedMedia", media="")
    browser.value("window.dispatchEvent(new Event('afterprint'))")
    browser.until(f"{height} === {screen}")


def test_cells_of_prose_are_wide_enough_to_read_on_a_phone(browser: Browser) -> None:
    browser.size(390, 800)
    assert browser.value("document.querySelector('td.long').getBoundingClientRect().width") >= 180


def test_names_below_narrow_cells_do_not_meet_on_a_phone(browser: Browser) -> None:
    browser.size(390, 800)
    labels = "[...document.querySelectorAll('#picture-4 .xtick text')].map((t) => t.getBoundingClientRect())"
    browser.until(f"{labels}.length === 11")
    browser.until(f"{labels}.every((t, k, all) => !k || t.left >= all[k - 1].right - 1)")


def test_names_of_a_waterfall_are_whole_on_a_phone(browser: Browser, tmp_path: Path) -> None:
    steps = [Step(effect="coulomb_friction", location="motor_1", share=0.9)]
    diagnosis = Diagnosis(
        verdict="explained", causes=(), ambiguity_groups=(), where=(), next_experiment=None, warnings=(), provenance={},
        gap=GapNumbers(metric="E", unit="1", before=9.0, after=1.1, noise_floor=1.0),
        waterfall=(Waterfall(joint="motor_2", before=1.0, steps=tuple(steps), left=0.1),),
    )  # fmt: skip
    file = tmp_path / "waterfall.html"
    file.write_text(
        page_html("Title", "s", [Chapter("One", (Picture(waterfall_figure(diagnosis), "c"),))], packed=True)
    )
    browser.size(390, 800)
    browser.open(file)
    browser.until("document.querySelectorAll('#picture-1 .ytick text').length === 3")
    edges = browser.value(
        "[...document.querySelectorAll('#picture-1 .ytick text')].map(e => e.getBoundingClientRect().left"
        " - document.querySelector('#picture-1').getBoundingClientRect().left)"
    )
    assert min(edges) >= 0


def shown(browser: Browser, figures: list[Picture], tmp_path: Path, width: int) -> None:
    file = tmp_path / "shown.html"
    file.write_text(page_html("Title", "s", [Chapter("One", tuple(figures))], packed=True))
    browser.size(width, 800)
    browser.open(file)


def test_value_beside_the_longest_bar_is_whole_on_a_phone(browser: Browser, tmp_path: Path) -> None:
    shown(browser, [Picture(_bars(["a", "b"], [0.999, 0.1], [BLUE, BLUE]), "c")], tmp_path, 390)
    browser.until("document.querySelectorAll('#picture-1 .bartext').length === 2")
    over = "document.querySelector('#picture-1 .bartext').getBoundingClientRect().right"
    assert browser.value(over) <= browser.value("document.getElementById('picture-1').getBoundingClientRect().right")


def test_bands_of_a_map_are_drawn_with_all_names(browser: Browser, tmp_path: Path) -> None:
    where = [
        Excess(joint=f"motor_{motor}", signal="sudden position change", band_hz=band, regime="all", share=0.2,
               p_value=0.5)
        for motor in (1, 2) for band in ((0.0, 2.0), (2.0, 9.0))
    ]  # fmt: skip
    for width in (1366, 390):
        shown(browser, [Picture(_spectrum(where, 200), "c")], tmp_path, width)
        browser.until("document.querySelectorAll('#picture-1 .ytick text').length === 2")
        edges = "[...document.querySelectorAll('#picture-1 .ytick text')].map(e => e.getBoundingClientRect().left)"
        left = browser.value("document.getElementById('picture-1').getBoundingClientRect().left")
        assert min(browser.value(edges)) >= left
    assert browser.messages == []


def test_picture_of_equal_scales_leaves_no_empty_space_on_a_phone(browser: Browser, tmp_path: Path) -> None:
    angle = np.linspace(0.0, 6.3, 50)
    figure = stacked([""], height=520)
    figure.add_trace(curve(np.cos(angle), np.sin(angle), "circle", BLUE, hover=""))
    figure.update_xaxes(constrain="domain")
    figure.update_yaxes(scaleanchor="x", constrain="domain")
    shown(browser, [Picture(figure, "c")], tmp_path, 390)
    browser.until("document.querySelector('#picture-1 .main-svg') !== null")
    size = "document.getElementById('picture-1').%s"
    assert browser.value(size % "clientHeight") < browser.value(size % "clientWidth") + 130


def test_picture_that_fails_does_not_take_the_others_with_it(browser: Browser, tmp_path: Path) -> None:
    import plotly.graph_objects as go

    figure = go.Figure([go.Heatmap(z=[[1]], x=[0, 1], y=[name]) for name in ("a", "b")])
    figure.update_layout(margin={"l": 50, "r": 8, "t": 8, "b": 8}, height=200)
    shown(browser, [Picture(figure, "wrong"), picture()], tmp_path, 1366)
    browser.until("document.querySelector('#picture-2 .main-svg') !== null")
    assert "cannot be drawn" in browser.value("document.getElementById('picture-1').textContent")
    assert browser.messages != []
    browser.messages.clear()


def test_panels_below_each_other_are_apart_on_paper(browser: Browser, tmp_path: Path) -> None:
    two = picture()
    two.figure.update_xaxes(title_text="time [s]")
    shown(browser, [two], tmp_path, 1366)
    browser.until("document.querySelector('#picture-1 .main-svg') !== null")
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.value("window.dispatchEvent(new Event('beforeprint'))")
    browser.until("document.getElementById('picture-1').layout.xaxis2.domain[0] > 0.57")
    label = "[...document.querySelectorAll('#picture-1 .xtitle')].map(e => e.getBoundingClientRect().bottom)"
    title = "[...document.querySelectorAll('#picture-1 .annotation-text')].map(e => e.getBoundingClientRect().top)"
    below = [top for top in browser.value(title) if top > min(browser.value(label)) - 30]
    assert len(below) == 2
    assert min(below) >= min(browser.value(label)) - 1
    browser.call("Emulation.setEmulatedMedia", media="")
    browser.value("window.dispatchEvent(new Event('afterprint'))")
