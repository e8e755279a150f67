"""How a plant ends: it brakes if it broke off, then waits until the recorder has everything; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.errors import FlexrosError

GOODBYE_TIMEOUT = 10.0
"""Longest wait at the end for the recorder [s], chosen: a lost message may take seconds to be sent again."""


class Ending:
    """Bookkeeping of a plant's end.

    Args:
        failure: Why the run broke off, None when it is done.
        brake_samples: Samples with zero torque that are to follow.

    Attributes:
        failure: Why the run broke off, None when it is done.
        braked: Samples with zero torque so far.
    """

    def __init__(self, failure: FlexrosError | None, brake_samples: int) -> None:
        self.failure = failure
        self.braked = 0
        self._to_brake = brake_samples
        self._waited = 0.0

    @property
    def brakes(self) -> bool:
        """Whether samples with zero torque are still to follow."""
        return self.braked < self._to_brake

    def brake(self) -> None:
        """Note one more sample with zero torque."""
        self.braked += 1
        self._waited = 0.0

    def give_up_braking(self) -> None:
        """Brake no more: the plant cannot be moved on."""
        self._to_brake = self.braked

    def wait(self, time: float) -> bool:
        """Note a wait for the recorder [s]; tells whether it has been too long since the last progress."""
        self._waited += time
        return self._waited > GOODBYE_TIMEOUT
