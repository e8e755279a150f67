"""What a model leaves of a log one sample ahead, and up to where that is no gap."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LeftOver:
    """What a model leaves of a log one sample ahead, where a gap of any kind shows: it decides whether there is one.

    Attributes:
        level: Mean squared prediction error one sample ahead over its floor variance [1].
        most: Up to where it is noise and tolerance [1].
        most_of_machine: Up to where it is so too in a log of a real machine in which the gap 0.1 s ahead is small [1];
            None in a simulated log.
        ahead: That gap [1].
        most_ahead: Up to where that gap is small: as for an explanation, floors with the tolerance of torques [1].
        lacking: Motors whose encoder has a coarse rounding that the model lacks, which is a gap.
        moving_on: Motors that the repaired model predicts hardly better than at constant speed, by a much larger
            inertia, which repairs nothing: that is a gap.
        strained: Numbers that are moved so far out of their tolerance that torques within theirs do not make it: what a
            real machine leaves beyond noise and tolerance is a gap then.
        assumed: Tolerance of the torques that hides a gap, relative to their rms, where nobody stated one [1]; None
            where there is no gap with a much smaller one either.
        if_known: The gap 0.1 s ahead with that one [1].
    """

    level: float
    most: float
    most_of_machine: float | None
    ahead: float
    most_ahead: float
    lacking: tuple[str, ...] = ()
    moving_on: tuple[str, ...] = ()
    strained: tuple[str, ...] = ()
    assumed: float | None = None
    if_known: float | None = None

    @property
    def beyond(self) -> bool:
        """Whether errors are beyond noise and tolerance, or the model lacks the rounding of an encoder."""
        return (self.level > self.most and (self.refused or not self._of_machine)) or bool(self.lacking)

    @property
    def refused(self) -> bool:
        """Whether numbers far out of their tolerance alone make a gap of what a real machine may leave."""
        return self.level > self.most and self._of_machine and bool(self.strained)

    @property
    def _of_machine(self) -> bool:
        """Whether a real machine may leave as much."""
        most = self.most_of_machine
        return most is not None and self.level <= most and self.ahead <= self.most_ahead

    @property
    def significant(self) -> bool:
        """Whether it is a gap."""
        return self.beyond or bool(self.moving_on)
