"""Names that a shell completes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from flexros.cli import completion
from flexros.effects import effects
from flexros.robot import robot_names
from flexros.scenario.scenario import scenario_names

PROGRAM = "import sys; sys.argv[0] = 'flexros'; from flexros.cli import main; main()"


def test_names_are_those_of_the_library() -> None:
    assert tuple(completion.robots("")) == robot_names()
    assert tuple(completion.scenarios("")) == scenario_names()
    assert set(completion.effects("")) == set(effects())
    assert completion.controllers("pid_o") == ["pid_optimised"]


def test_lists_and_places_of_effects() -> None:
    assert completion.effects("delay,backl") == ["delay,backlash"]
    assert completion.placed_effects("backl") == ["backlash@"]
    assert completion.placed_effects("backlash@mo") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("flexros robot six", "six_axis"),
        ("flexros run circle_d", "circle_dae"),
        ("flexros gap log --model four_mass_l", "four_mass_linear"),
        ("flexros run circle_pd --effect coul", "coulomb_friction@"),
    ],
)
def test_shell_gets_them(words: str, found: str) -> None:
    variables = {"_FLEXROS_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": words}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env={**os.environ, **variables}, capture_output=True, text=True, check=False
    )
    assert found in done.stdout, done.stderr
