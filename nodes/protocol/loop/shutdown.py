"""Plant shutdown: brake, then flush the recorder."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.errors import FlexrosError

FLUSH_TIMEOUT = 10.0
"""Longest wait for the recorder at the end [s], chosen: it can take seconds until a lost message is sent again."""


class Shutdown:
    """Progress of a plant shutdown.

    Args:
        failure: Why the run was aborted, None if it is complete.
        brake_samples: Number of samples with zero torque to append.

    Attributes:
        failure: Why the run was aborted, None if it is complete.
        braked: Samples with zero torque so far.
    """

    def __init__(self, failure: FlexrosError | None, brake_samples: int) -> None:
        self.failure = failure
        self.braked = 0
        self._brake_samples = brake_samples
        self._waited = 0.0

    @property
    def braking(self) -> bool:
        """Whether samples with zero torque remain to be sent."""
        return self.braked < self._brake_samples

    def count_brake_sample(self) -> None:
        """Count one more sample with zero torque."""
        self.braked += 1
        self._waited = 0.0

    def stop_braking(self) -> None:
        """Skip the remaining brake samples: the plant cannot be advanced."""
        self._brake_samples = self.braked

    def timed_out(self, time: float) -> bool:
        """Add a wait for the recorder [s]; return whether the wait since the last progress exceeds the limit."""
        self._waited += time
        return self._waited > FLUSH_TIMEOUT
