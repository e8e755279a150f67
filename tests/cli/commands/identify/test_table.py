"""The table of identified parameters fits the terminal, and no name or number in it is broken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from flexros.cli.commands.identify.table import parameter_table

STIFFNESS, DAMPING = "body_2.rz.stiffness [Nm/rad]", "body_2.rz.damping [Nm s/rad]"


def entry(name: str, unit: str, value: float, reach: float, verdict: str) -> SimpleNamespace:
    """Make an entry whose interval reaches by a factor both ways."""
    return SimpleNamespace(name=name, unit=unit, value=value, interval=(value / reach, value * reach), verdict=verdict)


@pytest.fixture
def result() -> Any:
    """Two parameters of a simulated robot, one of which is not determined."""
    entries = (
        entry("body_2.rz.stiffness", "Nm/rad", 2999496.0, 1.0002, "determined"),
        entry("body_2.rz.damping", "Nm s/rad", 35.27, 4.2, "not_determined"),
    )
    return SimpleNamespace(
        identifiability=SimpleNamespace(parameters=entries),
        nominal=np.array([2.5e6, 30.0]),
        truth={"body_2.rz.stiffness": 3e6},
    )


def printed(result: Any, width: int) -> list[str]:
    """Return the lines of the table."""
    console = Console(width=width)
    with console.capture() as capture:
        console.print(parameter_table(result, width))
    return capture.get().splitlines()


@pytest.mark.parametrize(("width", "columns"), [(120, {"nominal", "true"}), (80, {"nominal"}), (70, set())])
def test_columns_that_do_not_fit_are_left_out(result: Any, width: int, columns: set[str]) -> None:
    lines = printed(result, width)
    assert max(map(len, lines)) <= width
    assert {"nominal", "true"} & set(lines[1].split()) == columns
    assert {"parameter", "fitted", "verdict"} <= set(lines[1].split())


def test_names_and_numbers_stay_whole_at_80_columns(result: Any) -> None:
    lines = printed(result, 80)
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in lines if "│" in line]
    assert rows[0] == [STIFFNESS, "2500000", "2999500", "±0.020 %", "determined"]
    assert rows[1] == [DAMPING, "30", "35.3", "-76 +320 %", "not"]
    assert rows[2] == ["", "", "", "", "determined"]


def test_true_value_stands_beside_where_there_is_room(result: Any) -> None:
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in printed(result, 120) if "│" in line]
    assert [row[-1] for row in rows] == ["3000000", "-"]


def test_robot_without_truth_has_no_such_column(result: Any) -> None:
    result.truth = {}
    assert "true" not in printed(result, 120)[1]
