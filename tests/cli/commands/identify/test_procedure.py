"""Identification from the command line: the whole procedure, and its steps on what it left behind."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from flexros.cli import main
from flexros.identify.frf.files.netcdf import load_responses
from flexros.robot import load_robot
from tests.cli.conftest import Ended

pytestmark = pytest.mark.slow

Flexros = Callable[..., Ended]


@dataclass(frozen=True)
class Done:
    """Output and files of the whole procedure."""

    content: dict[str, object]
    folder: Path


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """Identify E12 whose first spring is 20 % stiffer and whose last damper is 30 % larger."""
    from contextlib import redirect_stdout
    from io import StringIO

    folder, text = tmp_path_factory.mktemp("identify") / "e12", StringIO()
    with redirect_stdout(text), pytest.raises(SystemExit) as caught:
        main(
            [
                "identify", "robot", "e12", "--out", str(folder), "--transport", "direct", "--json",
                "--positions", "2", "--candidates", "15", "--starts", "2", "--seed", "5", "--minutes", "1",
                "--set", "identification.transient_periods=2", "--set", "plant.values.body_1.ry.stiffness=1.2e5",
                "--effect", "damping_error@body_3.ry:relative=0.3",
            ]
        )  # fmt: skip
    assert not caught.value.code
    return Done(json.loads(text.getvalue()), folder)


def test_values_of_the_real_robot_are_found(done: Done) -> None:
    rows = {row["name"]: row for row in done.content["parameters"]}
    assert rows["body_1.ry.stiffness"]["truth"] == pytest.approx(1.2e5)
    assert rows["body_3.ry.damping"]["truth"] == pytest.approx(65)
    for row in rows.values():
        assert row["verdict"] == "determined"
        assert row["value"] == pytest.approx(row["truth"], rel=0.01 if row["unit"] == "Nm/rad" else 0.05)


def test_folder_holds_everything(done: Done) -> None:
    names = {path.name for path in done.folder.iterdir()}
    wanted = {"experiment.yaml", "log", "frf.nc", "identified.yaml", "identification.json", "report.html"}
    assert names == wanted
    stored = json.loads((done.folder / "identification.json").read_text())
    assert {**stored, "run": done.content["run"]} == done.content
    assert len(load_responses(done.folder / "frf.nc")) == 2


def test_identified_robot_is_a_robot(done: Done) -> None:
    robot = load_robot(done.folder / "identified.yaml")
    parameter = robot.parameters["body_1.ry.stiffness"]
    assert parameter.value == pytest.approx(1.2e5, rel=0.01)
    assert 0 < parameter.tolerance < 0.01
    assert "identified by FlexROS" in parameter.source


def test_experiment_stays_within_its_time(done: Done) -> None:
    assert 60 < done.content["experiment"]["robot_time"] <= 80


def test_stages_and_robot_time_are_told(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros(
        "identify", "robot", "e12", "--out", str(tmp_path / "one"), "--transport", "direct", "--positions", "1",
        "--candidates", "10", "--starts", "1", "--minutes", "0", "--set", "identification.transient_periods=1",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    assert [line for line in ended.err.splitlines() if line.startswith("flexros: ")] == [
        "flexros: designing the experiment", "flexros: running the experiment",
        "flexros: estimating frequency responses", "flexros: fitting from 1 start",
    ]  # fmt: skip
    before, after = ended.out.splitlines()[0], ended.out.splitlines()[-1]
    minutes = re.fullmatch(r"Experiment in 1 position: ([\d.]+) min of robot time", before)
    assert minutes
    assert after == f"Robot time: {minutes[1]} min"


def test_scenario_may_be_given_and_choices_changed(flexros: Flexros, done: Done, tmp_path: Path) -> None:
    scenario, out = str(done.folder / "experiment.yaml"), str(tmp_path / "frf.nc")
    ended = flexros(
        "identify", "frf", str(done.folder / "log"), "--scenario", scenario, "--out", out, "--json",
        "--set", "average=arithmetic",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    content = json.loads(ended.out)
    assert [row["blocks"] for row in content] == [2, 2]
    assert all(0 < row["relative_std"]["total"] < 0.1 for row in content)


def test_fit_of_some_parameters(flexros: Flexros, done: Done, tmp_path: Path) -> None:
    ended = flexros(
        "identify", "fit", str(done.folder / "frf.nc"), "--model", "e12", "--out", str(tmp_path / "fit"),
        "--unknown", "body_1.ry.stiffness", "--unknown", "body_3.ry.damping", "--weights", "user",
        "--estimator", "LLSM", "--starts", "2",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    assert "2 of 2 parameters of e12 are " in ended.out
    content = json.loads((tmp_path / "fit" / "identification.json").read_text())
    assert [row["name"] for row in content["parameters"]] == ["body_1.ry.stiffness", "body_3.ry.damping"]
    assert (content["estimator"], content["weights"]) == ("LLSM", "user")
    assert content["experiment"] is None


def test_fit_keeps_within_bounds(flexros: Flexros, done: Done, tmp_path: Path) -> None:
    ended = flexros(
        "identify", "fit", str(done.folder / "frf.nc"), "--model", "e12", "--out", str(tmp_path / "fit"), "--json",
        "--unknown", "body_1.ry.stiffness", "--starts", "2", "--bound", "body_1.ry.stiffness=2e5:3e5",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    content = json.loads(ended.out)
    assert content["parameters"][0]["value"] == pytest.approx(2e5)
    assert "On a bound of the search: body_1.ry.stiffness." in content["warnings"]
    assert content["kept_nominal"] == ["body_1.ry.stiffness"]
    assert load_robot(tmp_path / "fit" / "identified.yaml").parameters["body_1.ry.stiffness"].value == 1e5


def test_design_writes_a_scenario_that_can_be_run(flexros: Flexros, tmp_path: Path) -> None:
    from flexros.scenario.identification_plan import plan_of_scenario
    from flexros.scenario.scenario import load_scenario

    out = tmp_path / "experiment.yaml"
    ended = flexros(
        "identify", "design", "e12", "--out", str(out), "--positions", "4", "--candidates", "50", "--json",
        "--range", "motor_1=-0.1:0.1", "--set", "identification.blocks=3",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    content, scenario = json.loads(ended.out), load_scenario(out)
    assert scenario.identification is not None
    positions = scenario.identification.positions
    assert len(positions) == 4
    assert all(abs(gears[0]) <= 0.1 for gears in positions)
    assert scenario.identification.blocks == 3
    assert content["efficiency"] > content["random_efficiency"]["median"]
    assert content["duration_s"] == pytest.approx(plan_of_scenario(scenario).duration)


def test_design_is_shown_to_people(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros("identify", "design", "e12", "--out", str(tmp_path / "e.yaml"), "--candidates", "40")
    assert ended.code == 0, ended.err
    assert "body_3.ry.stiffness" in ended.out
    assert re.search(r"6 positions chosen out of \d+ (of 40 )?candidates", ended.out)
    assert "std: with optimal weights and noise alone" in " ".join(ended.out.split())
    assert "Next: flexros run" in ended.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["robot", "e21", "--out", "{}"], "unknown robot 'e21'"),
        (["robot", "e12", "--out", "{}", "--unknown", "body_1.ry.stifness"], "did you mean 'body_1.ry.stiffness'"),
        (["robot", "e12", "--out", "{}", "--real", "two_mass"], "robot two_mass cannot stand in for e12"),
        (["robot", "e12", "--out", "{}", "--transport", "udp"], "unknown transport 'udp'"),
        (["robot", "e12", "--out", "{}", "--set", "plant.valus.x=1"], "did you mean 'values'"),
        (["robot", "emps", "--out", "{}"], "robot emps has neither springs nor dampers"),
        (["design", "e12", "--out", "{}", "--range", "motor_3=0:1"], "unknown motor of robot e12 'motor_3'"),
        (["design", "e12", "--out", "{}", "--range", "motor_1=1:0"], "but must be MOTOR=LOW:HIGH"),
        (["design", "e12", "--out", "{}", "--range", "motor_1=a"], "but must be MOTOR=LOW:HIGH"),
        (["design", "e12", "--out", "{}", "--scenario", "circle_pd"], "scenario circle_pd has no key identification"),
        (["design", "e12", "--out", "{}", "--minutes", "nan"], "--minutes is nan, but must be a finite number of 0"),
        (["design", "e12", "--out", "{}", "--minutes=-3"], "--minutes is -3, but must be a finite number of 0"),
        (["robot", "e12", "--out", "{}", "--minutes", "inf"], "--minutes is inf, but must be a finite number of 0"),
        (["design", "e12", "--out", "{}", "--distortion", "nan"], "--distortion is nan, but must be a share"),
        (["design", "e12", "--out", "{}", "--distortion", "1.2"], "--distortion is 1.2, but must be a share"),
        (["fit", "{}/none.nc", "--model", "e12", "--out", "{}"], "none.nc"),
    ],
)
def test_bad_input_ends_with_2_and_one_sentence(
    flexros: Flexros, tmp_path: Path, arguments: list[str], message: str
) -> None:
    ended = flexros("identify", *(text.replace("{}", str(tmp_path / "out")) for text in arguments))
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.err.strip().splitlines()) == 1


def test_log_that_is_there_is_not_written_over_and_the_way_on_that_is_named_gives_the_same_responses(
    flexros: Flexros, done: Done, tmp_path: Path
) -> None:
    ended = flexros("identify", "robot", "e12", "--out", str(done.folder))
    assert ended.code == 2
    assert "log exists already; give another folder with --out, or go on with this log: flexros identify " in ended.err
    frf, fit = ended.err.strip().partition(": flexros ")[2].split("; flexros ")
    assert frf == f"identify frf {done.folder / 'log'} --out {done.folder / 'frf.nc'}"
    assert fit == f"identify fit {done.folder / 'frf.nc'} --model e12 --out {done.folder / 'fit'}"
    ended = flexros(*frf.split()[:-1], str(tmp_path / "frf.nc"))
    assert ended.code == 0, ended.err
    assert "position" in ended.out
    assert "--model e12 --out identified" in ended.err
    again, before = load_responses(tmp_path / "frf.nc"), load_responses(done.folder / "frf.nc")
    assert all((one.response == other.response).all() for one, other in zip(again, before, strict=True))
    assert flexros(*fit.split()[:-1], str(tmp_path / "fit"), "--starts", "1").code == 0


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--estimator", "FOO"), "--estimator: unknown estimator 'FOO'"),
        (("--weights", "foo"), "--weights: unknown kind of weights 'foo'"),
        (("--starts", "0"), "--starts: 0 starts were requested"),
        (("--layout", "threads"), "unknown layout 'threads' in --layout"),
        (("--bound", "body_1.ry.stiffness=2e5:1e5"), "body_1.ry.stiffness has the bounds 200000 and 100000"),
        (("--bound", "motor_1.inertia=50:200"), "--bound: unknown fitted parameter 'motor_1.inertia'"),
    ],
)
def test_choices_of_the_fit_are_checked_before_anything_moves(
    flexros: Flexros, tmp_path: Path, option: tuple[str, str], message: str
) -> None:
    ended = flexros("identify", "robot", "e12", "--out", str(tmp_path / "new"), *option)
    assert ended.code == 2
    assert message in ended.err
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--estimator", "LLT"), "unknown estimator 'LLT'"),
        (("--weights", "equal"), "unknown kind of weights 'equal'"),
        (("--starts", "0"), "0 starts were requested, but at least one is needed"),
        (("--seed", "-1"), "--seed: the seed is -1, but must be 0 or more"),
        (("--bound", "spring=1:2"), "--bound: unknown fitted parameter 'spring'"),
        (("--bound", "body_1.ry.stiffness=1e4"), "--bound is 'body_1.ry.stiffness=1e4', but must be NAME=LOW:HIGH"),
        (("--bound", "body_1.ry.stiffness=2e5:1e5"), "body_1.ry.stiffness has the bounds 200000 and 100000"),
        (("--scheduler", "tcp://127.0.0.1:9"), "--scheduler: no Dask scheduler answers at 'tcp://127.0.0.1:9'"),
    ],
)
def test_choices_of_a_fit_are_checked(
    flexros: Flexros, done: Done, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: tuple[str, str], message: str
) -> None:
    monkeypatch.setattr("flexros.scheduler.ANSWER", 0.5)
    ended = flexros(
        "identify", "fit", str(done.folder / "frf.nc"), "--model", "e12", "--out", str(tmp_path), *option
    )  # fmt: skip
    assert ended.code == 2
    assert message in ended.err


def test_log_of_another_scenario_is_refused(flexros: Flexros, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    assert flexros("run", "circle_pd", "--transport", "direct", "--out", str(bag)).code == 0
    ended = flexros("identify", "frf", str(bag), "--out", str(tmp_path / "frf.nc"))
    assert ended.code == 2
    assert "without identification" in ended.err


@pytest.mark.parametrize("command", ["robot", "design", "frf", "fit", "rigid"])
def test_every_step_has_help(flexros: Flexros, command: str) -> None:
    ended = flexros("identify", command, "--help")
    assert ended.code == 0
    assert "--json" in ended.out
    if command in ("robot", "design", "fit"):
        told = " ".join(ended.out.replace("│", " ").split())
        assert "replaces the default: the list of the robot file, else all its springs and dampers" in told
