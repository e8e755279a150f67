"""Parts of a record in samples: rest, excitation with fades, rest."""

from __future__ import annotations

from dataclasses import dataclass

from flexros.identify.excitation.base import whole_samples


@dataclass(frozen=True)
class RecordParts:
    """Lengths of the parts of a record.

    Attributes:
        before: Rest before the excitation [samples].
        length: Excitation [samples].
        after: Rest after it [samples].
        ramp: Fade in, and fade out, within the excitation [samples], from 1 to half its length.
    """

    before: int
    length: int
    after: int
    ramp: int

    @classmethod
    def of(
        cls, rest_before: float, duration: float, rest_after: float, taper: float, sample_time: float
    ) -> RecordParts:
        """Convert times to samples.

        Args:
            rest_before: Rest before the excitation [s].
            duration: Length of the excitation [s].
            rest_after: Rest after it [s].
            taper: Time to fade in, and to fade out [s], rounded to samples.
            sample_time: Time between two samples [s].

        Raises:
            InputError: A rest or the duration is not a whole number of samples, or the duration is below two samples.
        """
        before = whole_samples("rest_before", rest_before, sample_time, least=0)
        length = whole_samples("duration", duration, sample_time, least=2)
        after = whole_samples("rest_after", rest_after, sample_time, least=0)
        return cls(before, length, after, min(max(round(taper / sample_time), 1), length // 2))

    @property
    def total(self) -> int:
        """Length of the record [samples]."""
        return self.before + self.length + self.after

    @property
    def excited(self) -> slice:
        """Samples of the excitation."""
        return slice(self.before, self.before + self.length)
