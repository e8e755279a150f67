"""Next experiment: separation by simulation, the choice among experiments, the command."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from flexros.cli.commands.run import changed_scenario
from flexros.effects import PlacedEffect, RobotWithEffects, parse_effect
from flexros.errors import InputError, RunError
from flexros.gap.next_experiment import choose as module
from flexros.gap.next_experiment.catalogue import CATALOGUE, CatalogueEntry
from flexros.gap.next_experiment.choose import SLOWEST, Separated, command_of, next_experiment, separated
from flexros.gap.next_experiment.separation import Explained, separation, trial
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY
from flexros.scenario.experiment import Experiment
from tests.ur5e import ur5e

ENTRIES = {entry.name: entry for entry in CATALOGUE}


def placed(*texts: str) -> list[PlacedEffect]:
    return [parse_effect(text, "test") for text in texts]


def model(name: str = "four_mass_linear") -> RobotWithEffects:
    return RobotWithEffects(load_robot(name), ())


def gain(survivors: list[list[PlacedEffect]], entry: str) -> float:
    found = separated([Explained(model(), tuple(one)) for one in survivors], ENTRIES[entry], 101, 10.0)
    assert found is not None
    return found.gain


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "rival", "log"),
    [
        (
            "torque_gain_error@motor_1:relative=4e-5",
            "motor_inertia_error@motor_1:relative=-2e-4",
            {"diagnosis.length": 10, "diagnosis.parts": ["moves"], "diagnosis.intensity": 0.3, "diagnosis.poses": 1},
        ),
        (
            "actuator_lag@motor_1:time_constant=1.2e-4",
            "delay@all:time=1.2e-4",
            {"diagnosis.length": 10, "diagnosis.parts": ["creep"], "diagnosis.poses": 1},
        ),
    ],
)
def test_running_the_proposed_experiment_separates_what_the_log_did_not(
    truth: str, rival: str, log: dict[str, Any]
) -> None:
    true, other = (Explained(model(), tuple(placed(text))) for text in (truth, rival))
    assert separation(true, other, trial(true, log, 7)) < 3.0
    entries = [ENTRIES["standard"], ENTRIES["high_band"]]
    proposed = next_experiment(model(), [true.placed, other.placed], entries=entries)
    assert proposed is not None
    run = trial(true, ENTRIES[proposed.name].keys(true.model.robot, 20.0), 55)
    assert separation(true, other, run) > 4.0


@pytest.mark.slow
def test_a_known_load_tells_motor_inertia_from_torque_gain_better_than_rest() -> None:
    survivors = [
        placed("motor_inertia_error@motor_1:relative=0.003"),
        placed("torque_gain_error@motor_1:relative=-0.001"),
    ]
    assert gain(survivors, "known_payload") > 2 * gain(survivors, "static_holds")


@pytest.fixture
def gains(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Gains of the experiments that were evaluated."""
    seen: dict[str, float] = {}

    def noted(survivors: Sequence[Explained], entry: CatalogueEntry, *given: Any) -> Separated | None:
        found = separated(survivors, entry, *given)
        assert found is not None
        seen[entry.name] = found.gain
        return found

    monkeypatch.setattr(module, "separated", noted)
    return seen


@pytest.mark.slow
def test_the_chosen_experiment_is_the_best_except_for_cheaper_ones(gains: dict[str, float]) -> None:
    survivors = [placed("delay@all:time=0.00015"), placed("actuator_lag@motor_1:time_constant=0.00015")]
    entries = [ENTRIES["standard"], ENTRIES["high_band"]]
    chosen = next_experiment(load_robot("four_mass_linear"), survivors, entries=entries)
    assert chosen is not None
    assert chosen.name == "high_band"
    assert chosen.expected_gain > max(4.0, 2 * gains["standard"])
    assert [place.effect for place in chosen.separates] == ["delay", "actuator_lag"]


@pytest.mark.slow
def test_what_motors_cannot_see_needs_the_tool(gains: dict[str, float]) -> None:
    survivors = [placed("kinematic_error@body_1:length=0.001"), placed("kinematic_error@body_2:length=0.001")]
    entries = [ENTRIES["standard"], ENTRIES["tool_measurement"]]
    chosen = next_experiment(load_robot("elbow"), survivors, entries=entries)
    assert chosen is not None
    assert chosen.name == "tool_measurement"
    assert gains["standard"] == pytest.approx(0.0, abs=1e-6)


def test_a_tool_that_is_measured_already_is_not_proposed() -> None:
    survivors = [placed("kinematic_error@body_1:length=0.001"), placed("kinematic_error@body_2:length=0.001")]
    entries = [ENTRIES["tool_measurement"]]
    assert next_experiment(load_robot("elbow"), survivors, entries=entries, tool_measured=True) is None


def test_an_experiment_that_separates_by_far_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    gains = {"standard": 20.0, "creep_in_poses": 150.0, "high_band": 1e6}
    asked: list[str] = []

    def found(*arguments: Any) -> Separated:
        asked.append(arguments[1].name)
        return Separated(arguments[1], gains[arguments[1].name], (0, 1))

    monkeypatch.setattr(module, "separated", found)
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    chosen = next_experiment(load_robot("four_mass_linear"), survivors, entries=[ENTRIES[name] for name in gains])
    assert chosen is not None
    assert chosen.name == "creep_in_poses"
    assert asked == ["standard", "creep_in_poses"]


def test_a_choice_that_is_stopped_is_among_what_was_evaluated(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def found(*arguments: Any) -> Separated:
        asked.append(arguments[1].name)
        return Separated(arguments[1], 20.0, (0, 1))

    monkeypatch.setattr(module, "separated", found)
    robot, survivors = load_robot("four_mass_linear"), [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    chosen = next_experiment(robot, survivors, stop=lambda: len(asked) == 2)
    assert chosen is not None
    assert [entry.name for entry in CATALOGUE[:2]] == asked
    assert chosen.name in asked
    assert next_experiment(robot, survivors, stop=lambda: True) is None


def test_a_comparison_that_is_stopped_has_no_result() -> None:
    explained = [Explained(model(), tuple(placed(f"delay@all:time={time}"))) for time in (0.001, 0.002)]
    assert separated(explained, CATALOGUE[0], 101, 10.0, lambda: True) is None


def test_an_experiment_that_was_run_already_is_not_proposed() -> None:
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    entries = [ENTRIES["standard"]]
    assert next_experiment(load_robot("four_mass_linear"), survivors, entries=entries, done=["standard"]) is None


def test_one_explanation_needs_no_experiment() -> None:
    assert next_experiment(load_robot("four_mass_linear"), [placed("delay@all:time=0.001")]) is None


def test_an_experiment_that_would_be_aborted_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: Any, **__: Any) -> None:
        raise RunError("the state became infinite")

    monkeypatch.setattr(module, "trial", breaks)
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    assert next_experiment(load_robot("four_mass_linear"), survivors, entries=CATALOGUE[:1]) is None


def test_progress_ends_at_one(monkeypatch: pytest.MonkeyPatch) -> None:
    shares: list[float] = []
    monkeypatch.setattr(module, "separated", lambda *_: None)
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    next_experiment(load_robot("four_mass_linear"), survivors, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("entry", CATALOGUE, ids=lambda entry: entry.name)
def test_every_command_can_be_run(entry: CatalogueEntry) -> None:
    name = "elbow"
    words = shlex.split(command_of(entry.keys(load_robot(name), 20.0), name, 7))
    assert words[:5] == ["flexros", "run", "diagnosis", "--model", name]
    assert words[5:7] == ["--seed", "7"]
    assert set(words[7::2]) == {"--set"}
    scenario = changed_scenario("diagnosis", name, words[8::2], None, 7)
    assert 15.0 < Experiment.prepare(scenario).duration < 45.0


def test_an_experiment_that_is_not_possible_with_the_robot_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise InputError("motor_1 needs more than its limit to hold the initial pose")

    monkeypatch.setattr(module, "trial", refused)
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    assert next_experiment(load_robot("e12"), survivors) is None


def test_a_known_load_needs_a_last_body_with_a_mass() -> None:
    assert ENTRIES["known_payload"].keys(load_robot("elbow"), 10.0)["model.values.body_2.mass"] == pytest.approx(67.5)
    with pytest.raises(InputError, match="the last body of robot ur5e has no mass"):
        ENTRIES["known_payload"].keys(ur5e(), 10.0)


def test_names_of_experiments_are_given_once() -> None:
    assert len(ENTRIES) == len(CATALOGUE)
    assert all(entry.description and not entry.description.endswith(".") for entry in CATALOGUE)


@pytest.mark.parametrize(("log", "period"), [(0.0, 5e-4), (1e-4, 5e-4), (1e-3, 1e-3), (0.02, SLOWEST)])
def test_experiments_are_as_slow_as_the_recorder_of_the_log(
    log: float, period: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    used: list[float] = []

    def separated(explained: list[Explained], entry: CatalogueEntry, *rest: object) -> Separated:
        used.append(explained[0].model.robot.sample_time)
        return Separated(entry, 5.0, (0, 1))

    monkeypatch.setattr(module, "separated", separated)
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    proposed = next_experiment(load_robot("e12"), survivors, sample_time=log)
    assert proposed is not None
    assert set(used) == {period}
    assert (f"sample_time={period}" in shlex.split(proposed.command)) == (period > 5e-4)


def test_command_names_the_file_of_the_robot_or_its_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "separated", lambda _, entry, *__: Separated(entry, 5.0, (0, 1)))
    own = tmp_path / "own.yaml"
    own.write_bytes((LIBRARY / "four_mass.yaml").read_bytes())
    survivors = [placed("delay@all:time=0.001"), placed("delay@all:time=0.002")]
    for robot, name in ((load_robot(own), str(own)), (load_robot("e12").with_values({"body_3.mass": 190}), "e12")):
        proposed = next_experiment(robot, survivors)
        assert proposed is not None
        assert shlex.split(proposed.command)[4] == name
