"""Names that a shell completes."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest
import typer

from flexros.benchmark.controllers import controller_names
from flexros.cli import completion
from flexros.cli.app import app
from flexros.effects import effects
from flexros.robot import robot_names
from flexros.scenario.scenario import scenario_names

PROGRAM = "import sys; sys.argv[0] = 'flexros'; from flexros.cli import main; main()"


def test_names_are_those_of_the_library() -> None:
    assert tuple(completion.robots("")) == robot_names()
    assert tuple(completion.scenarios("")) == scenario_names()
    assert set(completion.effects("")) == set(effects())
    assert completion.controllers("pid_o") == ["pid_optimised"]


def test_words_are_those_that_the_commands_take() -> None:
    from flexros.benchmark.multivariable.problem import PROBLEMS
    from flexros.cli.commands.design.command import MARGINS
    from flexros.cli.commands.design.tuning import STRUCTURE
    from flexros.cli.commands.identify.procedure import LAYOUTS
    from flexros.cli.commands.run import TRANSPORTS
    from flexros.control.design.methods.base import design_methods
    from flexros.effects.patching.export import FORMATS
    from flexros.identify.graybox.estimators import ESTIMATORS
    from flexros.robot.exchange.urdf.export import FLEXIBLE
    from flexros.validation.campaigns.base import campaigns
    from flexros.validation.commands.bench import FOLDER

    taken = {
        "transport": TRANSPORTS, "layout": LAYOUTS, "torque": ("command", "measured"), "estimator": ESTIMATORS,
        "benchmark on": PROBLEMS, "design method": [*design_methods(), STRUCTURE, MARGINS], "export to": FORMATS,
        "robot flexible": FLEXIBLE, "campaign name": campaigns(),
        "bench name": [path.stem.removeprefix("bench_") for path in FOLDER.glob("bench_*.py")],
        "view what": [*robot_names(), "topics"], "design controller": [*controller_names(), *scenario_names()],
    }  # fmt: skip
    for argument, words in taken.items():
        assert sorted(completion.COMPLETED[argument]("")) == sorted(words), argument
    assert completion.COMPLETED["design controller"]("circle_d") == ["circle_dae", "circle_dae2"]


def test_every_argument_that_is_completed_belongs_to_a_command() -> None:
    """One that is renamed would lose its completion without a sign."""
    arguments = set()
    for path, command in leaves():
        arguments |= {each for one in command.params for each in (one.name, f"{path} {one.name}")}
    assert set(completion.COMPLETED) <= arguments


def leaves(group: Any = None, path: str = "") -> Iterator[tuple[str, Any]]:
    for name, command in (group or typer.main.get_command(app)).commands.items():
        below = f"{path} {name}".strip()
        if hasattr(command, "commands"):
            yield from leaves(command, below)
        else:
            yield below, command


def test_lists_and_places_of_effects() -> None:
    assert completion.effects("delay,backl") == ["delay,backlash"]
    assert completion.placed_effects("backl") == ["backlash@"]
    assert completion.placed_effects("backlash@mo") == []


IN_ZSH = {
    "flexros robot six": "six_axis",
    "flexros run circle_d": "circle_dae",
    "flexros gap log --model four_mass_l": "four_mass_linear",
    "flexros run circle_pd --effect coul": "coulomb_friction@",
}
EACH = """
import os, sys
from flexros.cli import main
asked, sys.argv = sys.argv[1:], ["flexros"]
for os.environ["_TYPER_COMPLETE_ARGS"] in asked:
    try:
        main()
    except SystemExit:
        print("END", flush=True)
"""


@pytest.fixture(scope="module")
def told_to_zsh() -> dict[str, str]:
    """Complete one after the other in one process."""
    variables = {**os.environ, "_FLEXROS_COMPLETE": "complete_zsh"}
    command = [sys.executable, "-c", EACH, *IN_ZSH]
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
    *told, _ = done.stdout.split("END\n")
    assert len(told) == len(IN_ZSH), done.stderr
    return dict(zip(IN_ZSH, told, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("words", IN_ZSH)
def test_shell_gets_them(told_to_zsh: dict[str, str], words: str) -> None:
    assert IN_ZSH[words] in told_to_zsh[words]


IN_BASH = {
    "flexros diag": ["diagnose"],
    "flexros run circle_dae --transp": ["--transport"],
    "flexros run circle_dae --transport di": ["direct"],
    "flexros campaign cov": ["coverage"],
    "flexros design margins --controller circle_dae": ["circle_dae", "circle_dae2"],
    "flexros analyze no_such_log": [],  # files are left to the shell
}


@pytest.fixture(scope="module")
def completed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Install the completion for bash, and complete in one shell."""
    folder = tmp_path_factory.mktemp("home")
    program = folder / "flexros"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -c {shlex.quote(PROGRAM)} "$@"\n')
    program.chmod(0o755)
    variables = {**os.environ, "HOME": str(folder), "PATH": f"{folder}:{os.environ['PATH']}"}
    variables["_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION"] = "1"
    script = f"{program} --install-completion bash >/dev/null && . ~/.bashrc\n" + "".join(
        f"COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); COMPREPLY=()\n"
        "_flexros_completion flexros; echo ${COMPREPLY[@]}\n"
        for words in IN_BASH
    )
    done = subprocess.run(["bash", "-c", script], env=variables, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    assert len(lines) == len(IN_BASH), done.stderr
    return {words: line.split() for words, line in zip(IN_BASH, lines, strict=True)}


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is needed")
@pytest.mark.parametrize("words", IN_BASH)
def test_bash_completes(completed: dict[str, list[str]], words: str) -> None:
    assert completed[words] == IN_BASH[words]
