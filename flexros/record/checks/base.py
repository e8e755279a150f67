"""Base class of the checks of a record, and their registry."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from flexros.discovery import members

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.record.checks.checked_record import CheckedRecord


@dataclass(frozen=True, eq=False)
class Finding:
    """A problem of a record.

    Attributes:
        text: One sentence without the name of the log: what was found, what is expected, what to do.
        hopeless: Whether a diagnosis of such a log would be wrong, so that it is rejected; else a warning is given.
        spoilt: Samples that must not count, shape (n,); None where all do.
        jumps: By how much the clock jumps before each sample [samples], shape (n,); None where it does not.
        like_parameters: Whether wrong parameters of the nominal robot look the same. Identification, which estimates
            them, warns of such a finding only.
        of_model: Whether it doubts the nominal model and not the log. A diagnosis whose repair closes much of the gap
            settles it.
        of_either: Whether it doubts the nominal model or the torques of the log. A diagnosis that explains the log
            without an error of the torque gain settles it.
    """

    text: str
    hopeless: bool
    spoilt: BoolArray | None = None
    jumps: FloatArray | None = None
    like_parameters: bool = False
    of_model: bool = False
    of_either: bool = False


class AbstractCheck(ABC):
    """A check of a record before any hypothesis is tested or any parameter is estimated.

    How to add one: write one file in `flexros/record/checks` with one final subclass; it is found by discovery. It
    provides:

    1. `name`, a class variable, and `stage`: 0 checks the amount of data, 1 single signals, 2 torque against motion. A
       stage is skipped where the one before found a log hopeless.
    2. `look`: the problems of a record, none for one that is usable as it is. An effect of realistic size is not a
       problem of a record.
    """

    name: ClassVar[str]
    stage: ClassVar[int]
    of_torque: ClassVar[bool] = False
    """Whether it checks a recorded torque. Like stage 2 it is left out where servos were commanded by positions."""

    @abstractmethod
    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Check a record.

        Args:
            checked: The record with its robot and the results that checks share.

        Returns:
            Problems; empty for a usable record.
        """


@cache
def checks() -> Mapping[str, type[AbstractCheck]]:
    """Return all checks of this package by name."""
    return members("flexros.record.checks", AbstractCheck)  # type: ignore[type-abstract]
