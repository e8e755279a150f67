"""Whether a record is long enough."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

SHORTEST = 2.0
"""Shortest record [s] (chosen)."""

FEWEST = 400
"""Fewest measured samples (chosen)."""

SHORT = 10.0
"""Length below which a third of the record is little for a holdout [s] (chosen)."""


class Length(AbstractCheck):
    """A record has to be long enough to be fitted, and a third of it to verify."""

    name: ClassVar[str] = "length"
    stage: ClassVar[int] = 0

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare duration and number of samples with the least."""
        record = checked.record
        measured = int(record.valid.sum())
        if record.duration < SHORTEST or measured < FEWEST:
            return (
                Finding(
                    f"the log is too short: it has {record.duration:.3g} s with {measured} measured samples, needed "
                    f"are {SHORTEST:g} s and {FEWEST} samples; record longer",
                    hopeless=True,
                ),
            )
        if record.duration < SHORT:
            return (
                Finding(
                    f"the log lasts {record.duration:.3g} s; below {SHORT:g} s weak effects stay hidden", hopeless=False
                ),
            )
        return ()
