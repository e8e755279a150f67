"""Settings of the search for locations."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flexros.config.settings import Settings


class WhereSettings(Settings):
    """Settings of the search for the locations of a gap."""

    realisations: int = Field(default=200, ge=20, description="simulated logs without a gap, for p-values [1]")
    floor: Literal["estimated", "predicted"] = Field(
        default="estimated",
        description="level of the noise: estimated from the highest octave of the log, or the standard deviations of "
        "the predictor",
    )
    lowest_hz: float = Field(default=2.0, gt=0, description="least upper end of the lowest octave band [Hz]")
    orders: float = Field(default=60.0, gt=1, description="highest order evaluated [periods per turn of the rotor]")
    least_freedom: float = Field(
        default=8.0, gt=0, description="degrees of freedom that a location needs to be tested [1]"
    )
    significant: float = Field(
        default=0.05, gt=0, lt=1, description="p-value up to which a location is significant [1]"
    )
    least_share: float = Field(
        default=0.02, ge=0, lt=1, description="share of the excess from which a location is reported [1]"
    )
    least_order_share: float = Field(
        default=0.01,
        ge=0,
        lt=1,
        description="the same for an order, which shows only while the rotor turns [1]",
    )
    least_score: float = Field(
        default=0.02,
        ge=0,
        description="concentration from which a location is reported, so that evenly spread excess names no regime "
        "[nats]",
    )
    most: int = Field(default=12, ge=1, description="largest number of locations reported [1]")
