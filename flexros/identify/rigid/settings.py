"""Settings of the rigid regression."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flexros.config.settings import Settings


class RigidSettings(Settings):
    """Low-pass, friction model and hold of the rigid regression."""

    cutoff: float | None = Field(
        None,
        gt=0,
        description="cut-off of the low-pass for the positions [Hz]; default: a tenth of the rate, up to 100",
    )
    asymmetric: bool = Field(False, description="viscous and Coulomb friction by direction of motion, without offset")
    torque: Literal["command", "measured"] = Field(
        "command", description="torque that is taken where both were recorded; the other one where it alone was"
    )
    hold: bool = Field(
        False, description="pair positions with the commanded torque as it acts: delayed and held, not with its samples"
    )

    prescribed: tuple[str, ...] = Field(
        (),
        description="motors whose torque does not count, beside those without any: what they move is felt by the "
        "torques of the others",
    )

    def cutoff_at(self, rate: float) -> float:
        """Return the cut-off [Hz] at a sampling rate [Hz]."""
        return min(rate / 10, 100.0) if self.cutoff is None else self.cutoff
