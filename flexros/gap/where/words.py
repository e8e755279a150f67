"""A place in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.gap.schema import Excess

_REGIMES = {
    "all": "",
    "standstill": "at standstill",
    "reversal": "at reversals",
    "low speed": "at low speed",
    "high speed": "at high speed",
    "vibration": "in vibration",
    "high torque": "under high torque",
    "gear torque reversal": "where the gear torque changes its sign",
    "high acceleration": "under high acceleration",
    "first third": "in the first third of the log",
    "last third": "in the last third of the log",
}


def sentence(place: Excess, sample_time: float) -> str:
    """Write a place as people say it, e.g. "motor_2, below 4 Hz, at reversals: 63 % of the excess".

    Args:
        place: The place.
        sample_time: Time between two samples of its signal [s]; a band up to its Nyquist frequency is "above ... Hz".
    """
    low, high = place.band_hz
    top = high >= 0.99 * 0.5 / sample_time
    band = "" if low <= 0 and top else f"below {high:.3g} Hz" if low <= 0 else f"{low:.3g} to {high:.3g} Hz"
    if top and low > 0:
        band = f"above {low:.3g} Hz"
    regime = _REGIMES.get(place.regime, f"at {place.regime}")
    what = "sudden changes" if place.signal.startswith("sudden") else "excess"
    if place.signal.endswith("lines"):
        what = f"excess of the multisines, at {place.signal}"
    where = ", ".join(part for part in (place.joint, band, regime) if part)
    return f"{where}: {100 * place.share:.0f} % of the {what}"
