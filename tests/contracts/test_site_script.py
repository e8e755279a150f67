"""The script of the docs site: modules of API pages are folded, and links into them open them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.browser import Browser, opened_browser

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.slow
PAGE = '<!DOCTYPE html><meta name="viewport" content="width=device-width"><body>{}<script>{}</script></body>'
SCRIPT = Path(__file__).parents[2] / "docs" / "site.js"


def module(name: str, *children: str) -> str:
    below = "".join(children)
    return (
        f'<div class="doc doc-object doc-module"><h2 id="{name}" class="doc doc-heading">'
        f'<span class="doc doc-object-name">{name}</span></h2><div class="doc doc-contents"><p>What {name} is.</p>'
        f'<div class="doc doc-children">{below}</div></div></div>'
    )


def function(name: str) -> str:
    heading = f'<h3 id="{name}" class="doc doc-heading"><span class="doc doc-object-name">{name}</span></h3>'
    return f'<div class="doc doc-object doc-function">{heading}<div style="height: 3000px">long</div></div>'


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with opened_browser() as one:
        yield one


@pytest.fixture
def page(tmp_path: Path) -> Path:
    file = tmp_path / "api.html"
    room = module("room", module("fit", function("solve"), module("inner", function("deep"))), module("empty"))
    file.write_text(PAGE.format(room, SCRIPT.read_text()))
    return file


def test_modules_are_folded_with_the_names_they_hold(browser: Browser, page: Path) -> None:
    browser.size(390, 800)
    browser.open(page)
    assert browser.value("document.documentElement.scrollHeight") < 900
    assert browser.value("[...document.querySelectorAll('summary')].map((e) => e.textContent)") == [
        "solve, inner",
        "deep",
    ]
    assert browser.value("document.querySelector('details p').textContent") == "What inner is."
    assert browser.messages == []


def test_a_link_opens_what_it_leads_to(browser: Browser, page: Path) -> None:
    browser.open(page)
    browser.value("location.hash = '#deep'")
    browser.until("[...document.querySelectorAll('details')].every((e) => e.open)")
    browser.until("Math.abs(document.getElementById('deep').getBoundingClientRect().top) < 5")


def test_everything_is_printed(browser: Browser, page: Path) -> None:
    browser.open(page)
    browser.value("window.dispatchEvent(new Event('beforeprint'))")
    assert browser.value("[...document.querySelectorAll('details')].every((e) => e.open)")
