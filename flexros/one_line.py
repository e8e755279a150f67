"""Texts for a terminal that hold what others wrote."""

from __future__ import annotations

from flexros.input_limits import LONGEST_SENTENCE


def one_line(text: str) -> str:
    """Make a text one line that can be printed anywhere.

    Names from a foreign file may hold what moves the cursor of a terminal, hides text, or has no end.

    Args:
        text: The text.

    Returns:
        The text with everything that cannot be seen written as in Python, and the middle of a very long one left out.
    """
    text = _shortened(text)
    return text if text.isprintable() else _shortened("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text))


def _shortened(text: str) -> str:
    kept = LONGEST_SENTENCE // 2 - 5
    return text if len(text) <= LONGEST_SENTENCE else f"{text[:kept]} ... {text[-kept:]}"
