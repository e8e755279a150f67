"""One case as scored: the sealed truth and the answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.validation.blind.score.nested import same, same_place

if TYPE_CHECKING:
    from flexros.gap.schema import Cause, Diagnosis
    from flexros.validation.blind.score.crowd_truth import CrowdTruth
    from flexros.validation.blind.score.third_log import ThirdLog
    from flexros.validation.blind.seal import Truth

VISIBLE = 50.0
"""Expected gain from which a deviation is well above the noise [nats] (contract of section 10)."""
NO_GAP, UNKNOWN, REFUSED = "no gap", "unknown", "refused"
"""Entry of the confusion matrix where no effect is named."""


@dataclass(frozen=True, eq=False)
class Answer:
    """A case.

    Attributes:
        truth: What was hidden.
        diagnosis: Reported answer; None where the log was rejected.
        seconds: How long the diagnosis took [s]; None where not known.
        oracle: Closed fraction of the true structure, refitted [1]; None where not computed.
        third: Gap of the third log with the patch; None where not measured, or where there is no patch.
        crowd: Figures of the true effects of a crowd; None where not measured.
    """

    truth: Truth
    diagnosis: Diagnosis | None
    seconds: float | None = None
    oracle: float | None = None
    third: ThirdLog | None = None
    crowd: CrowdTruth | None = None

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Causes that are claimed, in their order; none where no gap was found."""
        if self.diagnosis is None or self.diagnosis.verdict == "no_gap":
            return ()
        return self.diagnosis.causes

    @property
    def first(self) -> Cause | None:
        """First cause that is claimed."""
        return self.causes[0] if self.causes else None

    @property
    def visible(self) -> bool:
        """Whether the hidden deviation is well above the noise."""
        return self.truth.gain >= VISIBLE

    @property
    def alarm(self) -> bool:
        """Whether a gap was claimed."""
        return self.diagnosis is not None and self.diagnosis.verdict != "no_gap"

    @property
    def unknown(self) -> bool:
        """Whether the answer was an unknown effect."""
        return self.diagnosis is not None and self.diagnosis.verdict == "unknown_effect"

    def named(self, top: int, nested: bool = False, placed: bool = False) -> bool:
        """Whether a true effect is among the first causes.

        Args:
            top: How many of the causes count.
            nested: Whether effects that hold the true one as a special case count.
            placed: Whether the place must be right as well.
        """
        return any(self.right(cause, nested, placed) for cause in self.causes[:top])

    def right(self, cause: Cause, nested: bool = False, placed: bool = False) -> bool:
        """Whether a cause is part of the truth; arguments as for `named`."""
        return any(
            same(one.effect, cause.effect, nested)
            and (not placed or same_place(self.truth.robot, one.location, cause.location))
            for one in self.truth.deviations
        )

    def both(self, nested: bool = False) -> bool:
        """Whether each of two true effects is among the first two causes."""
        first = self.causes[:2]
        return all(any(same(one.effect, cause.effect, nested) for cause in first) for one in self.truth.deviations)

    @property
    def group_size(self) -> int:
        """Number of effects in the ambiguity group of the first cause; 1 where it has no rival."""
        if self.first is None or self.diagnosis is None:
            return 1
        here = (self.first.effect, self.first.location)
        groups = self.diagnosis.ambiguity_groups
        return max((len(group) for group in groups if here in {(p.effect, p.location) for p in group}), default=1)

    @property
    def in_group(self) -> bool:
        """Whether a true effect is in the ambiguity group of the first cause, or is it."""
        if self.first is None or self.diagnosis is None:
            return False
        here = (self.first.effect, self.first.location)
        names = {self.first.effect}
        for group in self.diagnosis.ambiguity_groups:
            if here in {(place.effect, place.location) for place in group}:
                names |= {place.effect for place in group}
        return any(one.effect in names for one in self.truth.deviations)

    @property
    def missed(self) -> str:
        """Return the error of the answer in a few words; empty where it is right or the hidden effect is small."""
        kind, faint = self.truth.kind, self.truth.kind in ("single", "pair") and not self.visible
        if self.diagnosis is None:
            return "refused"
        if kind == "null":
            return "false alarm" if self.alarm else ""
        if faint or (kind == "unknown" and self.unknown):
            return ""
        if not self.alarm:
            return "not detected"
        if kind == "unknown":
            return "a known effect is named"
        if self.unknown:
            return "reported as unknown"
        if self.both() if kind == "pair" else self.named(1):
            return ""
        if kind == "pair":
            return "one of the two is missing" if self.named(2) else "both are missing"
        return "ambiguous, another effect first" if self.in_group else "another effect first"

    @property
    def reported(self) -> str:
        """The answer in a word, for the confusion matrix."""
        if self.diagnosis is None:
            return REFUSED
        if self.unknown:
            return UNKNOWN
        return NO_GAP if self.first is None else self.first.effect

    @property
    def closed(self) -> float | None:
        """Closed fraction that the diagnosis states [1]."""
        return None if self.diagnosis is None else self.diagnosis.gap.closed_fraction

    @property
    def closed_third(self) -> float | None:
        """Closed fraction of the patch on the log that neither fit nor check has seen [1]."""
        return None if self.third is None else self.third.closed_fraction

    @property
    def closed_rival(self) -> float | None:
        """Closed fraction of the best impostor: the best explanation that was not chosen [1]."""
        gap = None if self.diagnosis is None else self.diagnosis.gap
        if gap is None or gap.closed_fraction is None or gap.best_rival is None:
            return None
        return (gap.before - gap.best_rival) / (gap.before - gap.noise_floor)
