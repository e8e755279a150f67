"""Which of the many places are told: the significant ones in which the excess is most concentrated, each thing once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.gap.schema import Excess

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.where.places import FoundPlace
    from flexros.gap.where.settings import WhereSettings

LEAST_SHARE = 0.02
"""Share of the excess that a place needs to be told (chosen)."""
LEAST_ORDER_SHARE = 0.01
"""The same of an order, which is seen only while the rotor turns (chosen)."""
LEAST_SCORE = 0.02
"""Concentration that a place needs to be told, so that what is evenly spread names no regime [nats] (chosen)."""


def told(places: Sequence[FoundPlace], settings: WhereSettings) -> tuple[Excess, ...]:
    """Choose what is told.

    Args:
        places: All places.
        settings: Numbers of the search.

    Returns:
        Significant places by concentration of the excess, of each joint at most one per kind of regime.
        Where the excess is spread evenly over everything, the whole of the joint with the largest share.
    """
    significant = [
        place
        for place in places
        if place.p_value <= settings.significant
        and place.share >= (LEAST_ORDER_SHARE if place.family == "motor angle" else LEAST_SHARE)
    ]
    ordered = sorted(significant, key=lambda place: (-place.score, -place.share, place.p_value))
    chosen: list[FoundPlace] = []
    kinds = set()
    for place in ordered:
        kind = (place.joint, place.family)
        if place.score >= LEAST_SCORE and kind not in kinds:
            kinds.add(kind)
            chosen.append(place)
    if not chosen and significant:
        chosen = [max(significant, key=lambda place: place.share)]
    return tuple(_plain(place) for place in chosen[: settings.most])


def looked_at(places: Sequence[FoundPlace]) -> tuple[Excess, ...]:
    """Choose what maps of the excess are drawn from.

    Args:
        places: All places.

    Returns:
        Per joint and single octave over the regime "all", per joint and regime over the whole band, and per joint the
        order that stands out most, significant or not.
    """
    found: list[FoundPlace] = []
    best: dict[str, FoundPlace] = {}
    for place in places:
        if place.family == "motor angle":
            rival = best.get(place.joint)
            if rival is None or (place.p_value, -place.share) < (rival.p_value, -rival.share):
                best[place.joint] = place
        elif (place.regime == "all" and place.bands == 1) or (place.regime != "all" and place.bands == 0):
            found.append(place)
    return tuple(_plain(place) for place in _of_all_axes([*found, *best.values()]))


def _of_all_axes(places: Sequence[FoundPlace]) -> list[FoundPlace]:
    """Keep of equal places of the tool's components the one with the largest share."""
    kept: dict[tuple[object, ...], FoundPlace] = {}
    for place in places:
        key = (place.signal, place.joint, place.band_hz, place.regime)
        if key not in kept or place.share > kept[key].share:
            kept[key] = place
    return list(kept.values())


def _plain(place: FoundPlace) -> Excess:
    return Excess(
        signal=place.signal,
        joint=place.joint,
        band_hz=(round(place.band_hz[0], 3), round(place.band_hz[1], 3)),
        regime=place.regime,
        share=place.share,
        p_value=place.p_value,
    )
