"""Quantities and units of foreign logs."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.config.topics import load_topics
from flexros.logs.foreign.quantities import QUANTITIES, UNITS, units_of


def test_every_quantity_becomes_a_field_of_a_topic_in_a_known_unit() -> None:
    topics = load_topics()
    for quantity in QUANTITIES.values():
        assert quantity.field in topics[quantity.topic].fields
        assert units_of(quantity.kind)


def test_no_two_quantities_share_a_field() -> None:
    measured = [quantity for quantity in QUANTITIES.values() if not quantity.beyond_motor]
    assert len({(quantity.topic, quantity.field) for quantity in measured}) == len(measured)


@pytest.mark.parametrize(
    ("unit", "value", "si"),
    [("deg", 180.0, np.pi), ("rpm", 60.0, 2 * np.pi), ("mm", 5.0, 5e-3), ("kNm", 2.0, 2000.0), ("turn", 0.5, np.pi)],
)
def test_unit_in_si(unit: str, value: float, si: float) -> None:
    assert value * UNITS[unit].factor == pytest.approx(si, rel=1e-15)


def test_units_of_a_kind() -> None:
    assert units_of("torque") == ["Nm", "mNm", "kNm", "N", "kN"]
