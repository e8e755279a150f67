"""How it is looked for where a gap shows."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flexros.config.settings import Settings


class WhereSettings(Settings):
    """Numbers that are chosen, not measured."""

    realisations: int = Field(
        default=200, ge=20, description="simulated logs without gap that p-values are read from [1]"
    )
    floor: Literal["estimated", "predicted"] = Field(
        default="estimated",
        description="level of the noise: the log's own, from the highest octave, or the standard deviations of the "
        "predictor",
    )
    lowest_hz: float = Field(default=2.0, gt=0, description="upper end of the lowest band, at least [Hz]")
    orders: float = Field(default=60.0, gt=1, description="highest order looked at [periods per turn of the rotor]")
    significant: float = Field(default=0.05, gt=0, lt=1, description="p-value up to which a place is told [1]")
    most: int = Field(default=12, ge=1, description="places that are told at most [1]")
