"""Check the length of a record."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

SHORTEST = 2.0
"""Shortest record [s] (chosen)."""

FEWEST = 200
"""Fewest measured samples (chosen)."""

SHORT = 10.0
"""Length below which a third of the record is short for a holdout [s] (chosen)."""

NEARLY = 0.995
"""Share of a length that counts as it: clocks of recorders are a little fast, and a sample gets lost [1] (chosen)."""


class Length(AbstractCheck):
    """A record must be long enough for a fit, and a third of it for verification."""

    name: ClassVar[str] = "length"
    stage: ClassVar[int] = 0

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare length, the last sample included, and number of samples with their minima."""
        record = checked.record
        length, measured = record.duration + record.sample_time, int(record.valid.sum())
        if length < NEARLY * SHORTEST or measured < FEWEST:
            return (
                Finding(
                    f"the log is too short: it has {length:.3g} s with {measured} measured samples, at "
                    f"least {SHORTEST:g} s and {FEWEST} samples are needed; record longer",
                    hopeless=True,
                ),
            )
        if length < NEARLY * SHORT:
            return (
                Finding(
                    f"the log lasts {length:.3g} s; below {SHORT:g} s weak effects remain undetected",
                    hopeless=False,
                ),
            )
        return ()
