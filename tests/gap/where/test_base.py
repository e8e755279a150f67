"""The registry of views."""

from __future__ import annotations

from flexros.gap.where.base import AbstractSimulatedView, AbstractTestedView, views


def test_views_are_found_by_themselves_in_the_order_of_their_ranks() -> None:
    assert [view.name for view in views()] == [
        "position_bands",
        "tool_bands",
        "innovations",
        "order_spectrum",
        "detection_lines",
        "sensor_bands",
    ]
    assert len({view.rank for view in views()}) == len(views())
    assert all(issubclass(view, (AbstractSimulatedView, AbstractTestedView)) for view in views())


def test_views_of_one_signal_describe_it_alike() -> None:
    words = {(signal, text) for view in views() for signal, text in view.words.items()}
    assert len(words) == len({signal for signal, _ in words})
