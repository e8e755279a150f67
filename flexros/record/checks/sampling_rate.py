"""Check for a rate at which parts of the robot are not visible."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

LOW = 90.0
"""Rate below which a log is one of a servo loop, in which fast effects are not visible [Hz] (chosen)."""


class SamplingRate(AbstractCheck):
    """At a low rate, vibrations beyond half of it, short delays and reversals of friction fall between samples."""

    name: ClassVar[str] = "sampling_rate"
    stage: ClassVar[int] = 1

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the rate with that of servo logs."""
        rate = 1 / checked.record.sample_time
        if rate >= LOW:
            return ()
        text = (
            f"the log has {rate:.4g} samples per second, so vibrations above {rate / 2:.3g} Hz do not show, and delays "
            f"and lags below about {1e3 / rate:.2g} ms, backlash and presliding friction hardly do; friction at speed, "
            "gravity, inertia and slow modes do"
        )
        return (Finding(text, hopeless=False),)
