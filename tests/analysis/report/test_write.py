from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from flexros.analysis import analyse, circle_test
from flexros.analysis.comparison import Comparison, MethodRun
from flexros.analysis.figures_table import figure_rows
from flexros.analysis.report import write_comparison, write_report
from flexros.errors import InputError

pytestmark = pytest.mark.slow


class Tags(HTMLParser):
    """Collects tags, text outside scripts, and the data of the pictures."""

    def __init__(self) -> None:
        super().__init__()
        self.tags = []
        self.texts = []
        self.pictures = None
        self._inside = ""

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._inside = dict(attrs).get("id", tag) if tag in ("script", "style") else ""

    def handle_endtag(self, tag):
        self._inside = ""

    def handle_data(self, data):
        if self._inside == "pictures":
            self.pictures = json.loads(data)
        elif not self._inside:
            self.texts.append(data)


def parsed(file):
    tags = Tags()
    tags.feed(file.read_text(encoding="utf-8"))
    return tags


@pytest.fixture(scope="module")
def runs(make_run):
    return [analyse(make_run(), label="one"), analyse(make_run(cycles=3, jitter=2e-5), label="three")]


@pytest.fixture(scope="module")
def page(runs, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    write_report(runs, file)
    return file


def test_page_loads_nothing_from_elsewhere(page):
    loading = [
        (tag, name, value)
        for tag, attributes in parsed(page).tags
        for name, value in attributes.items()
        if name in ("src", "href", "srcset", "data", "action", "poster")
        and not (value or "").startswith(("data:", "#"))
    ]
    assert loading == []
    style = re.search(r"<style>(.*?)</style>", page.read_text(encoding="utf-8"), re.DOTALL)
    assert style is not None
    assert "url(" not in style[1]
    assert "@import" not in style[1]


def test_plotly_is_embedded_once(page):
    text = page.read_text(encoding="utf-8")
    assert len(re.findall(r"<script>/\*\*?\s*\n?\s*\* plotly\.js", text)) == 1


def test_every_picture_has_its_element_and_caption(page):
    tags = parsed(page)
    places = [attributes["id"] for tag, attributes in tags.tags if attributes.get("class") == "picture"]
    assert places == [picture["id"] for picture in tags.pictures]
    assert len(places) == sum(text.startswith("Figure ") for text in tags.texts)


def test_figures_in_the_page_equal_the_analysis(page, runs):
    texts = [text.replace("\u00a0", " ") for text in parsed(page).texts]
    at = texts.index("All figures", texts.index("All figures") + 1)  # the first is in the contents
    for row in figure_rows(runs):
        at = texts.index(row.name, at)
        assert tuple(texts[at + (1 if not row.unit else 2) :][:2]) == row.values


def test_a_magnified_curve_can_be_redrawn_from_the_page(page):
    picture = parsed(page).pictures[0]
    assert {curve["trace"] for curve in picture["magnified"]} == {1, 2, 3, 4, 5}
    assert all(len(curve["base"]) == len(curve["deviation"]) for curve in picture["magnified"])


def test_names_are_not_taken_for_markup(make_run, tmp_path):
    file = tmp_path / "report.html"
    write_report([analyse(make_run(), label="</script><b>x")], file)
    tags = parsed(file)
    assert "<b>x" not in file.read_text(encoding="utf-8").replace("\\/script><b>x", "")
    assert tags.pictures is not None
    assert any("</script><b>x" in text for text in tags.texts)


def test_a_report_without_pictures_embeds_no_library(make_run, tmp_path):
    log = make_run()
    bare = replace(log, joint_reference=None, joint_commands=None, tool_pose=None, tool_reference=None)
    file = tmp_path / "report.html"
    write_report([analyse(bare)], file)
    assert file.stat().st_size < 50_000


def test_a_long_run_does_not_swell_the_page(make_run, tmp_path):
    short, long = tmp_path / "short.html", tmp_path / "long.html"
    write_report([analyse(make_run(cycles=10))], short)
    write_report([analyse(make_run(cycles=40))], long)
    assert long.stat().st_size < 1.1 * short.stat().st_size


def test_nothing_but_the_report_is_left(page):
    assert [file.name for file in page.parent.iterdir()] == ["report.html"]


def test_a_report_is_replaced(runs, page):
    before = page.read_text(encoding="utf-8")
    write_report(runs, page)
    assert page.read_text(encoding="utf-8") == before


def test_a_folder_that_is_absent_is_named(runs, tmp_path):
    file = tmp_path / "absent" / "report.html"
    with pytest.raises(
        InputError, match=r"cannot be written to '.*absent.report\.html' \(No such file.*give another file"
    ):
        write_report(runs, file)


def test_a_report_of_no_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="no run was given for the report: give at least one log"):
        write_report([], tmp_path / "report.html")


def test_comparison_shows_quoted_figures_this_run_and_caveats(make_run, tmp_path):
    methods = ((circle_test.PD, 9e-3), (circle_test.DAE, 3.3e-4))
    runs = tuple(MethodRun(m, circle_test.NOMINAL, analyse(make_run(error=e), label=m)) for m, e in methods)
    comparison = Comparison(runs, circle_test.QUOTED_FIGURES, circle_test.CAVEATS)
    file = tmp_path / "comparison.html"
    write_comparison(comparison, file, title="Circle test")
    texts = parsed(file).texts
    at = texts.index(circle_test.DAE)
    row = next(row for row in comparison.rows() if row.method == circle_test.DAE and row.case == circle_test.NOMINAL)
    assert tuple(texts[at + 1 : at + 6]) == row.texts()[1:]
    assert set(circle_test.CAVEATS) <= set(texts)


def test_a_comparison_of_no_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="no run was given for the comparison"):
        write_comparison(Comparison(()), tmp_path / "comparison.html")


@pytest.mark.parametrize("label", ["<!--<script>", "</script><b>x", "<![CDATA["])
def test_a_hostile_label_neither_ends_nor_swallows_the_page(make_run, tmp_path, label):
    file = tmp_path / "report.html"
    write_report([analyse(make_run(), label=label)], file)
    text = file.read_text(encoding="utf-8")
    start = text.index('id="pictures">') + len('id="pictures">')
    data = text[start : text.index("</script>", start)]
    assert "<" not in data
    assert label in json.dumps(json.loads(data), ensure_ascii=False)
    assert parsed(file).tags[-1][0] == "script"
