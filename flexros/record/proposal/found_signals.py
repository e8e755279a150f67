"""The signals of a file by quantity and joint, as their names tell them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class FoundSignals:
    """Signals of the joints of a bag or a table.

    Attributes:
        states: Topic of the measured states of a bag; the file of a table.
        signals: Name of the signal by quantity and joint of the file.
        ignored: Topics or columns with numbers that were left out, with the reason.
        of_table: Whether they are columns of a table.
        time: Column of the times of a table; empty for a bag, whose messages have stamps, and for a table whose rate is
            known.
        currents: Quantities of torques whose signals are currents, by their names.
        unnamed: Columns by joint of the file that are commands, but whose names say no quantity.
    """

    states: str
    signals: Mapping[str, Mapping[str, str]]
    ignored: Mapping[str, str] = field(default_factory=dict)
    of_table: bool = False
    time: str = ""
    currents: frozenset[str] = frozenset()
    unnamed: Mapping[str, str] = field(default_factory=dict)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints with a measured position, in the order of the messages, or of their numbers."""
        return tuple(self.signals["position"])
