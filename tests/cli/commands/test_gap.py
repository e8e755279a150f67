"""The gap numbers from the command line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexros.cli.commands import gap
from flexros.errors import InputError
from flexros.logs.write_log import write_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

PATCH = """\
robot: {robot}
effects:
  - effect: coulomb_friction
    location: motor_1
    parameters: {{level: {level}}}
"""


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Ten seconds of the diagnosis experiment, with and without hidden friction."""
    folder, made = tmp_path_factory.mktemp("bags"), {}
    for name, effects in (("hidden", ["coulomb_friction@motor_1:level=0.05"]), ("clean", [])):
        values = {"diagnosis.length": 10, "diagnosis.parts": ["moves"], "plant.effects": effects, "seed": 4}
        log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(values, "test")))
        write_log(log, folder / name)
        made[name] = str(folder / name)
    measured = replace(log.joint_states, effort=0.8 * log.joint_commands.effort)
    write_log(replace(log, joint_states=measured), folder / "measured")
    made["measured"] = str(folder / "measured")
    return made


def patch(folder: Path, level: float, robot: str = "four_mass_linear") -> str:
    file = folder / f"patch_{level}.yaml"
    file.write_text(PATCH.format(robot=robot, level=level), encoding="utf-8")
    return str(file)


def test_a_model_that_misses_something_is_told_so(flexros, bags: dict[str, str]) -> None:
    ended = flexros("gap", bags["hidden"], "--model", "four_mass_linear", "--json")
    assert ended.code == 1, ended.err
    numbers = json.loads(ended.out)
    assert set(numbers) == {"metric", "unit", "before", "noise_floor"}
    assert numbers["before"] > 100


def test_the_true_model_has_no_gap(flexros, bags: dict[str, str]) -> None:
    ended = flexros("gap", bags["clean"], "--model", "four_mass_linear")
    assert ended.code == 0, ended.err
    assert ended.out.startswith("no gap: the errors of the model are no more than noise and tolerance\nGap (")


def test_a_patch_closes_the_gap(flexros, bags: dict[str, str], tmp_path: Path) -> None:
    ended = flexros("gap", bags["hidden"], "--model", "four_mass_linear", "--patch", patch(tmp_path, 0.05), "--json")
    assert ended.code == 0, ended.err
    numbers = json.loads(ended.out)
    assert numbers["closed_fraction"] == pytest.approx(1.0, abs=0.01)
    assert numbers["interval"][0] <= numbers["closed_fraction"] <= numbers["interval"][1]
    assert numbers["after"] < 1.5 < numbers["before"]


def test_half_a_patch_leaves_a_gap(flexros, bags: dict[str, str], tmp_path: Path) -> None:
    ended = flexros("gap", bags["hidden"], "--model", "four_mass_linear", "--patch", patch(tmp_path, 0.03))
    assert ended.code == 1, ended.err
    assert ended.out.startswith("a gap: the errors of the repaired model are more than noise and tolerance")
    assert "closed" in ended.out


def test_a_patch_is_a_model(flexros, bags: dict[str, str], tmp_path: Path) -> None:
    assert flexros("gap", bags["hidden"], "--model", patch(tmp_path, 0.05)).code == 0


def test_a_patch_of_another_robot_is_refused(flexros, bags: dict[str, str], tmp_path: Path) -> None:
    other = patch(tmp_path, 0.05, "two_mass")
    ended = flexros("gap", bags["hidden"], "--model", "four_mass_linear", "--patch", other)
    assert ended.code == 2
    assert f"--patch {other} is on top of two_mass, not of --model four_mass_linear; give that model" in ended.err


def test_the_source_of_the_torque_is_chosen(flexros, bags: dict[str, str]) -> None:
    command, measured = (
        flexros("gap", bags["measured"], "--model", "four_mass_linear", "--torque", source).code
        for source in ("command", "measured")
    )
    assert (command, measured) == (0, 1)


def test_a_log_that_one_of_two_models_accepts_is_not_refused() -> None:
    models = [SimpleNamespace(robot=name) for name in ("repaired", "nominal", "other")]

    def check(robot: str) -> str:
        if robot != "nominal":
            raise InputError(f"refused for {robot}")
        return "record"

    assert gap._checked(models, check) == "record"
    with pytest.raises(InputError, match="refused for repaired"):
        gap._checked(models[::2], check)


def test_unknown_source_of_the_torque_is_bad_input(flexros, bags: dict[str, str]) -> None:
    ended = flexros("gap", bags["clean"], "--model", "four_mass_linear", "--torque", "curent")
    assert ended.code == 2
    assert "curent" in ended.err
    assert "measured" in ended.err
