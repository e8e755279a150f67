"""Settings of the rigid regression."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class RigidSettings(Settings):
    """How positions become speeds and accelerations, and what friction is sought."""

    cutoff: float | None = Field(
        None, gt=0, description="of the low-pass for the positions [Hz]; default: a tenth of the rate, at most 100 Hz"
    )
    asymmetric: bool = Field(False, description="viscous and Coulomb friction by direction of motion, without offset")
    hold: bool = Field(
        False, description="pair positions with the commanded torque as it acts: delayed and held, not with its samples"
    )

    def cutoff_at(self, rate: float) -> float:
        """Return the cut-off [Hz] at a sampling rate [Hz]; the default is chosen."""
        return min(rate / 10, 100.0) if self.cutoff is None else self.cutoff
