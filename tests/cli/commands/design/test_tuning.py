"""Options of a search for a controller."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.cli.commands.design.tuning import SEED, STEP, Tuning


@pytest.mark.parametrize(
    ("tuning", "options"),
    [
        (Tuning(0, STEP, SEED, None, ""), []),
        (Tuning(0, 0.1, 2, None, ""), []),
        (Tuning(5, STEP, SEED, None, ""), ["--tune 5"]),
        (
            Tuning(5, 0.1, 2, Path("a.yaml"), "C2"),
            ["--tune 5", "--step 0.1", "--seed 2", "--start a.yaml", "--only C2"],
        ),
    ],
)
def test_options_are_those_that_are_not_the_default(tuning: Tuning, options: list[str]) -> None:
    assert tuning.options == options
