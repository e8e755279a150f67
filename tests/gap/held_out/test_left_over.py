"""What a model leaves one sample ahead decides whether there is a gap."""

from __future__ import annotations

import pytest

from flexros.gap.held_out.left_over import LeftOver
from flexros.gap.report.terminal import left_line


@pytest.mark.parametrize(
    ("level", "of_machine", "ahead", "most_ahead", "lacking", "gap"),
    [
        (1.03, None, 50.0, 2.0, (), False),
        (1.05, None, 1.0, 2.0, (), True),
        (1.9, 2.0, 1.9, 2.0, (), False),
        (1.9, 2.0, 3.3, 2.0, (), True),
        (1.9, 2.0, 18.3, 40.6, (), False),
        (2.1, 2.0, 1.0, 40.6, (), True),
        (1.0, 2.0, 1.0, 2.0, ("motor_1",), True),
    ],
)
def test_the_number_and_its_bound_decide(
    level: float, of_machine: float | None, ahead: float, most_ahead: float, lacking: tuple[str, ...], gap: bool
) -> None:
    left = LeftOver(level, 1.04, of_machine, ahead, most_ahead, lacking)
    assert left.significant is gap
    line = left_line(left)
    assert float(line.split(": ")[1].split(",")[0]) == level
    assert "up to 1.040 is noise" in line
    assert ("or up to 2 " in line) == (of_machine is not None)
    assert all(name in line for name in lacking)
