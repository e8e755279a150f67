"""What a check of the installation has found."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping

State = Literal["ok", "limited", "broken"]
"""ok; limited: something optional is missing or slow; broken: FlexROS does not work as it is."""


@dataclass(frozen=True)
class Finding:
    """One finding.

    Attributes:
        name: What was checked.
        state: How it is.
        text: What was found, one sentence.
        remedy: What to do, empty where it is ok.
        facts: The values behind it, ready for JSON; units are in the keys.
    """

    name: str
    state: State
    text: str
    remedy: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return the finding for JSON."""
        return {
            "name": self.name,
            "state": self.state,
            "text": self.text,
            "remedy": self.remedy,
            "facts": dict(self.facts),
        }
