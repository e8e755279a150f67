"""Quantities of foreign logs."""

from __future__ import annotations

from flexros.config.topics import load_topics
from flexros.logs.foreign.quantities import QUANTITIES
from flexros.logs.foreign.units import units_of


def test_every_quantity_becomes_a_field_of_a_topic_in_a_known_unit() -> None:
    topics = load_topics()
    for quantity in QUANTITIES.values():
        assert quantity.field in topics[quantity.topic].fields
        assert units_of(quantity.kind)


def test_no_two_quantities_share_a_field() -> None:
    assert len({(quantity.topic, quantity.field) for quantity in QUANTITIES.values()}) == len(QUANTITIES)
