"""One assumption of a proposed mapping."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Assumption:
    """What was assumed of a bag, and on what ground.

    Attributes:
        about: Subject: "topics", "commands", "joints", "signs", "position", "velocity", "effort", "rate",
            "robot" or "other topics".
        taken: What was taken.
        ground: What shows it, or that nothing does.
        checked: Whether the log or the model confirms it; otherwise it is a convention that may be wrong.
    """

    about: str
    taken: str
    ground: str
    checked: bool
