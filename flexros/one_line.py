"""Safe one-line text for a terminal from untrusted content."""

from __future__ import annotations

from flexros.input_limits import LONGEST_SENTENCE


def one_line(text: str) -> str:
    """Return a text as one printable line.

    Names from a foreign file may hold control sequences or be very long. Unprintable characters are escaped as in
    Python, and the middle of a very long text is omitted.
    """
    text = _shortened(text)
    return text if text.isprintable() else _shortened("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text))


def _shortened(text: str) -> str:
    kept = LONGEST_SENTENCE // 2 - 5
    return text if len(text) <= LONGEST_SENTENCE else f"{text[:kept]} ... {text[-kept:]}"
