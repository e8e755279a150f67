"""Sentences about locations of a gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.where.base import views
from flexros.gap.where.regimes import REGIMES

if TYPE_CHECKING:
    from flexros.gap.schema import Excess


def sentence(location: Excess, sample_time: float) -> str:
    """Describe a location, e.g. "motor_2, below 4 Hz, at reversals: 63 % of the excess".

    Args:
        location: The location.
        sample_time: Sample time of its signal [s]; a band up to the Nyquist frequency is written "above ... Hz".
    """
    low, high = location.band_hz
    top = high >= 0.99 * 0.5 / sample_time
    band = "" if low <= 0 and top else f"below {high:.3g} Hz" if low <= 0 else f"{low:.3g} to {high:.3g} Hz"
    if top and low > 0:
        band = f"above {low:.3g} Hz"
    regime = REGIMES[location.regime].phrase if location.regime in REGIMES else f"at {location.regime}"
    words = {signal: text for view in views() for signal, text in view.words.items()}
    where = ", ".join(part for part in (location.joint, band, regime) if part)
    return f"{where}: {100 * location.share:.0f} % of the {words.get(location.signal, 'excess')}"
