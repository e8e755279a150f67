"""Changes of single attributes in an XML text; everything else, comments and layout included, stays as it was.

The parsers of the standard library and lxml write a document anew, with other quotes and line breaks. Here expat finds
the start tags, and only these are changed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_START_TAG = re.compile(rb"<(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")


@dataclass(eq=False)
class XmlElement:
    """An element of the text.

    Attributes:
        tag: Its name.
        attributes: Its attributes, as changed so far.
        children: Elements inside.
        content: Text between its tags, where it has no children.
    """

    tag: str
    attributes: dict[str, str]
    _start: int
    _head: bytes
    children: list[XmlElement] = field(default_factory=list)
    content: str = ""
    _content_end: int = 0
    _length: int = 0
    _inside: bytes = b""
    _text: bytes | None = None

    def __post_init__(self) -> None:
        self._length = len(self._head)

    def iter(self, tag: str) -> Iterator[XmlElement]:
        """Yield the elements of a name at any depth, in order."""
        waiting = self.children[::-1]
        while waiting:  # no recursion: a document may be nested deeper than Python's stack
            element = waiting.pop()
            if element.tag == tag:
                yield element
            waiting += element.children[::-1]

    def find(self, tag: str) -> XmlElement | None:
        """Return the first child of a name, None for none."""
        return next((child for child in self.children if child.tag == tag), None)

    def set(self, name: str, value: str) -> None:
        """Set an attribute; a new one stands last."""
        self.attributes[name] = value
        quoted = quoteattr(value).encode()
        pattern = re.compile(rb"(\s" + re.escape(name.encode()) + rb"\s*=\s*)(\"[^\"]*\"|'[^']*')")
        if pattern.search(self._head):
            self._head = pattern.sub(lambda found: found[1] + quoted, self._head, count=1)
            return
        end = 2 if self._head.endswith(b"/>") else 1
        before = self._head[:-end].rstrip()
        self._head = before + b" " + name.encode() + b"=" + quoted + self._head[len(before) : -end] + self._head[-end:]

    def remove(self, name: str) -> None:
        """Remove an attribute, if it is there."""
        if self.attributes.pop(name, None) is not None:
            pattern = re.compile(rb"\s+" + re.escape(name.encode()) + rb"\s*=\s*(\"[^\"]*\"|'[^']*')")
            self._head = pattern.sub(b"", self._head, count=1)

    def add(self, tag: str, attributes: Mapping[str, str], texts: Mapping[str, str] | None = None) -> None:
        """Add a first child, with attributes, and children that hold a text each."""
        written = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
        inside = "".join(f"<{name}>{escape(text)}</{name}>" for name, text in (texts or {}).items())
        self._inside += (f"<{tag}{written}>{inside}</{tag}>" if inside else f"<{tag}{written}/>").encode()

    def add_text(self, tag: str, text: str) -> None:
        """Add a first child that holds a text."""
        self._inside += f"<{tag}>{escape(text)}</{tag}>".encode()

    def set_text(self, text: str) -> None:
        """Replace the content of an element without children."""
        self._text = escape(text).encode()

    def close(self, document: bytes, end: int) -> None:
        """Set where the content ends [byte of the document]."""
        self._content_end = end
        if not self.children:
            self.content = document[self._start + self._length : end].decode()

    def change(self) -> tuple[int, int, bytes]:
        """Return the range of the document that the element sets, and its new bytes."""
        head, closed = self._head, self._head.endswith(b"/>")
        added = self._inside + (self._text or b"")
        if added and closed:
            head = head[:-2].rstrip() + b">" + added + b"</" + self.tag.encode() + b">"
        elif added:
            head += added
        end = self._start + self._length
        if self._text is not None and not closed:
            end = self._content_end
        return self._start, end, head


class XmlText:
    """An XML text whose start tags can be changed.

    Attributes:
        source: The file, for error messages.
    """

    def __init__(self, text: str, source: str) -> None:
        """Parse the text.

        Args:
            text: The document.
            source: The file, for error messages.

        Raises:
            InputError: It is not XML, or has a document type definition.
        """
        if "<!ENTITY" in text or "<!DOCTYPE" in text:
            raise InputError(f"{source} has a document type definition, which it does not need; remove it")
        self.source = source
        self._content = text.encode()
        self._stack: list[XmlElement] = []
        self._elements: list[XmlElement] = []
        self._root: XmlElement | None = None
        self._parser = parser = expat.ParserCreate("utf-8")
        parser.StartElementHandler = self._begin
        parser.EndElementHandler = self._end
        try:
            parser.Parse(self._content, True)
        except expat.ExpatError as error:
            raise InputError(f"{source} is not XML ({error}); correct it") from error

    @property
    def root(self) -> XmlElement:
        """The outermost element."""
        assert self._root is not None
        return self._root

    def text(self) -> str:
        """Return the document with all changes."""
        parts, done = [], 0
        for start, end, new in (element.change() for element in self._elements):
            parts += [self._content[done:start], new]
            done = end
        return b"".join([*parts, self._content[done:]]).decode()

    def _begin(self, tag: str, attributes: dict[str, str]) -> None:
        start = self._parser.CurrentByteIndex
        head = _START_TAG.match(self._content, start)
        assert head is not None
        element = XmlElement(tag, dict(attributes), start, head[0])
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self._root = element
        self._stack.append(element)
        self._elements.append(element)

    def _end(self, tag: str) -> None:
        del tag
        element = self._stack.pop()
        element.close(self._content, self._parser.CurrentByteIndex)
