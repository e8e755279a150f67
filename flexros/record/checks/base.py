"""What a check of a record is, and how all of them are found."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from flexros.discovery import members

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray
    from flexros.record.checks.checked_record import CheckedRecord


@dataclass(frozen=True, eq=False)
class Finding:
    """A problem of a record.

    Attributes:
        text: One sentence: what was found, what is expected, what to do; without the name of the log.
        hopeless: Whether a diagnosis of such a log would be wrong, so that it is refused; else it is warned of.
        spoilt: Samples that must not count, shape (n,); None where all do.
    """

    text: str
    hopeless: bool
    spoilt: BoolArray | None = None


class AbstractCheck(ABC):
    """A look at a record before any hypothesis is tried.

    How to add one: write one file in `flexros/record/checks` with one final subclass; it is then found by its name. It
    provides:

    1. `name`, a class variable, and `stage`: 0 looks whether there is enough to look at, 1 looks at single signals, 2
       compares torque with motion. A stage is not asked where the one before found a log hopeless.
    2. `look`: what is wrong with a record, nothing for one that is usable as it is. An effect of realistic size is no
       problem of a record.
    """

    name: ClassVar[str]
    stage: ClassVar[int]

    @abstractmethod
    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Look at a record.

        Args:
            checked: The record with its robot and what checks share.

        Returns:
            Problems, none where all is well.
        """


@cache
def checks() -> Mapping[str, type[AbstractCheck]]:
    """Find all checks in this package, by name."""
    return members("flexros.record.checks", AbstractCheck)  # type: ignore[type-abstract]
