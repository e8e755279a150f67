"""Changes of single attributes in an XML text."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.robot.exchange.xml_text import XmlText

TEXT = """<?xml version='1.0'?>
<!-- head: ü -->
<a>
  <b name = 'x>y'   q="1"/>  <!-- kept -->
  <c><d>5</d>
     <e
        w="2"/></c>
</a>
"""


def test_unchanged_text_is_the_same() -> None:
    assert XmlText(TEXT, "t").text() == TEXT


def test_only_the_attribute_changes() -> None:
    document = XmlText(TEXT, "t")
    element = next(document.root.iter("b"))
    assert element.attributes == {"name": "x>y", "q": "1"}
    element.set("q", "2")
    element.set("new", 'a"b')
    assert document.text() == TEXT.replace('q="1"/>', 'q="2" new=\'a"b\'/>')


def test_an_attribute_is_removed_with_the_blank_before_it() -> None:
    document = XmlText(TEXT, "t")
    next(document.root.iter("b")).remove("q")
    next(document.root.iter("e")).remove("missing")
    assert document.text() == TEXT.replace('   q="1"', "")


def test_children_and_texts() -> None:
    document = XmlText(TEXT, "t")
    inner = next(document.root.iter("d"))
    assert inner.content == "5"
    inner.set_text("6")
    next(document.root.iter("e")).add("f", {"g": "1"})
    next(document.root.iter("b")).add("h", {}, {"i": "<"})
    changed = document.text()
    assert "<d>6</d>" in changed
    assert 'w="2"><f g="1"/></e></c>' in changed
    assert "<h><i>&lt;</i></h></b>  <!-- kept -->" in changed


@pytest.mark.parametrize("text", ["<a>", "", "<!DOCTYPE a><a/>"])
def test_broken_text_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="^t "):
        XmlText(text, "t")


def test_deep_documents_are_read() -> None:
    text = "<a>" * 20_000 + '<b c="1"/>' + "</a>" * 20_000
    document = XmlText(text, "t")
    next(document.root.iter("b")).set("c", "2")
    assert document.text() == text.replace('"1"', '"2"')
