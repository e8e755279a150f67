"""Selection of the locations that are reported, and of those that maps show."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.gap.schema import Excess
    from flexros.gap.settings import WhereSettings
    from flexros.gap.where.base import Location


def reported(locations: Sequence[Location], settings: WhereSettings) -> tuple[Excess, ...]:
    """Select the significant locations by concentration of the excess, at most one per joint and kind of regime.

    Where the excess is evenly spread, this is the significant location with the largest share.

    Args:
        locations: All locations of the views that are tested by simulated logs.
        settings: Settings of the search.
    """
    candidates = [location for location in locations if _is_significant(location, settings)]
    ordered = sorted(candidates, key=lambda location: (-location.score, -location.share, location.p_value))
    chosen: list[Location] = []
    kinds = set()
    for location in ordered:
        kind = (location.joint, location.kind)
        if location.score >= settings.least_score and kind not in kinds:
            kinds.add(kind)
            chosen.append(location)
    if not chosen and candidates:
        chosen = [max(candidates, key=lambda location: location.share)]
    return tuple(location.excess() for location in chosen[: settings.most])


def significant(locations: Iterable[Location], settings: WhereSettings) -> tuple[Excess, ...]:
    """Select all significant locations.

    Args:
        locations: Locations with p-values of their own.
        settings: Settings of the search.
    """
    return tuple(location.excess() for location in locations if _is_significant(location, settings))


def mapped(locations: Iterable[Location]) -> tuple[Excess, ...]:
    """Select the locations that maps show, of the tool's components the one with the largest share.

    Args:
        locations: All locations.
    """
    kept: dict[tuple[object, ...], Location] = {}
    for location in locations:
        if location.mapped:
            key = (location.signal, location.joint, location.band_hz, location.regime)
            if key not in kept or location.share > kept[key].share:
                kept[key] = location
    return tuple(location.excess() for location in kept.values())


def _is_significant(location: Location, settings: WhereSettings) -> bool:
    return location.p_value <= settings.significant and location.share >= location.least_share
