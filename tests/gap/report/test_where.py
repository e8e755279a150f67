"""The map of the excess over frequency."""

from __future__ import annotations

import math
from collections.abc import Callable

from flexros.gap.report.where import WhereSection, _spectrum
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import Excess
from flexros.report.base import TextTable


def excess(signal: str, low: float, high: float, share: float, p_value: float = 0.5) -> Excess:
    return Excess(joint="motor_1", signal=signal, band_hz=(low, high), regime="all", share=share, p_value=p_value)


def test_bands_of_several_signals_stand_at_their_own_frequencies() -> None:
    figure = _spectrum([excess("position", 0.0, 2.0, 0.1), excess("position", 2.0, 8.0, 0.6, 0.001),
                        excess("torque", 0.0, 5.0, 0.3)], 200)  # fmt: skip
    assert [(list(cell.x), list(cell.y)) for cell in figure.data] == [
        ([1.2, 2.0], [-0.5, 0.5]), ([2.0, 8.0], [-0.5, 0.5]), ([1.2, 5.0], [0.5, 1.5]),
    ]  # fmt: skip
    assert list(figure.layout.yaxis.ticktext) == ["motor_1 position", "motor_1 torque"]
    assert {cell.zmax for cell in figure.data} == {60.0}
    texts = figure.layout.annotations
    assert [text.text for text in texts] == ["10", "60<br>●", "30"]
    assert math.isclose(10 ** texts[1].x, 4.0)


def test_marks_of_the_frequency_axis_are_whole_numbers() -> None:
    """Without a format, 20 and 50 Hz were written as 2 and 5."""
    axis = _spectrum([excess("position", 0.0, 2.0, 0.1), excess("position", 2.0, 80.0, 0.6)], 200).layout.xaxis
    assert (axis.type, axis.dtick, axis.tickformat) == ("log", "D2", "~g")


def test_the_bound_of_a_p_value_is_that_of_its_own_row(changed: Callable[..., DiagnosisResult]) -> None:
    """Lines of a multisine are tested by themselves, without simulated logs."""
    places = (excess("odd detection lines", 0.0, 30.0, 0.9, 1e-6), excess("position", 0.0, 2.0, 0.6, 1 / 201))
    blocks = WhereSection().blocks(changed("explained", excess=places))
    (table,) = (block for block in blocks if isinstance(block, TextTable))
    assert [row[-1] for row in table.rows] == ["< 0.001", "≤ 0.005"]
    assert "at most 0.005, none of 200 simulated logs" in table.caption
