"""The gap numbers from the command line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexros.cli.commands import gap
from flexros.errors import InputError
from flexros.gap.held_out.left_over import LeftOver
from flexros.logs.write_log import write_log
from flexros.robot import library
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.gap.servo_logs import servo_log

pytestmark = pytest.mark.slow

PATCH = """\
robot: {robot}
effects:
  - effect: coulomb_friction
    location: motor_1
    parameters: {{level: {level}}}
"""


SERVO = """\
name: servo_joint
gravity: [0, 0, -9.81]
sample_time: 0.004
sensors: {encoder_noise: 1.0e-4}
bodies:
  - mass: 1.5
    center_of_mass: [0, 0, 0.2]
    inertia: {yy: 0.02}
    directions:
      ry:
        spring: rigid
        motor: {inertia: 0.05, viscous_friction: 0.3, torque_limit: 30, servo: {stiffness: 60, damping: 2}}
outputs: {joints: {coordinates: [body_1.ry]}}
controlled: joints
"""


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Ten seconds of the diagnosis experiment, with and without hidden friction; as of a real machine too."""
    folder, made = tmp_path_factory.mktemp("bags"), {}
    for name, level in (("rough", 0.15), ("hidden", 0.05), ("clean", 0.0)):
        effects = [f"coulomb_friction@motor_1:level={level}"] if level else []
        values = {"diagnosis.length": 10, "diagnosis.parts": ["moves"], "plant.effects": effects, "seed": 4}
        log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(values, "test")))
        write_log(log, folder / name)
        made[name] = str(folder / name)
        write_log(replace(log, provenance={"import": {"files": ["run.csv"]}}), folder / f"imported_{name}")
        made[f"imported_{name}"] = str(folder / f"imported_{name}")
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


NONE, A_GAP = LeftOver(1.0, 1.04, None, 1.0, 2.0), LeftOver(2.0, 1.04, None, 1.0, 2.0)
HIDDEN = replace(NONE, assumed=0.05, if_known=260.5)


@pytest.mark.parametrize(
    ("left", "command"),
    [
        (A_GAP, "flexros diagnose 'a b' --model e12 --out diagnosis    which effect causes it"),
        (
            HIDDEN,
            "flexros diagnose 'a b' --model e12 --out diagnosis    which effects the assumed tolerance",
        ),
        (NONE, "flexros monitor 'a b' --model e12 "),
    ],
)
def test_next_step_after_a_gap_names_log_and_model(left: LeftOver, command: str) -> None:
    assert gap.next_step(Path("a b"), "e12", None, left).startswith(command)


@pytest.mark.parametrize(
    ("source", "options"),
    [
        ("", "--to urdf --out repaired.urdf"),
        ("panda.urdf", "--to urdf --base panda.urdf --out repaired.urdf"),
        ("wx250s.xml", "--to mjcf --base wx250s.xml --out repaired.xml"),
    ],
)
def test_next_step_after_a_repaired_gap_is_an_export_into_the_imported_file(
    source: str, options: str, tmp_path: Path
) -> None:
    text = Path(library.__path__[0], "elbow.yaml").read_text(encoding="utf-8")
    text = re.sub("(?m)^defaults: .*$", f'defaults: {{source: "{source}"}}', text)
    (tmp_path / "arm.yaml").write_text(text, encoding="utf-8")
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: arm.yaml\neffects: []\n", encoding="utf-8")
    assert f"flexros export {patch} {options}  " in gap.next_step(Path("a"), "e12", patch, NONE)


@pytest.mark.parametrize(
    ("bag", "hidden", "following"), [("rough", True, "flexros diagnose"), ("clean", False, "flexros monitor")]
)
def test_what_an_assumed_tolerance_of_torques_hides_is_told(
    flexros, bags: dict[str, str], bag: str, hidden: bool, following: str
) -> None:
    ended = flexros("gap", bags[f"imported_{bag}"], "--model", "four_mass_linear")
    assert ended.code == 0, ended.err
    assert ended.out.startswith("no gap: ")
    assert ("is assumed, not measured" in ended.out) is hidden
    assert f"Next: {following} " in ended.err


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


def test_what_decides_is_printed_with_its_bound(flexros, bags: dict[str, str]) -> None:
    ended = flexros("gap", bags["hidden"], "--model", "four_mass_linear")
    decides = next(line for line in ended.out.splitlines() if line.startswith("Decides"))
    level, bound = (float(decides.split(before)[1].split(after)[0]) for before, after in ((": ", ","), ("to ", " is")))
    assert level > bound > 1.0


def test_a_patch_that_a_diagnosis_without_a_gap_did_not_write_is_told(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "diagnosis.json").write_text("{}", encoding="utf-8")
    read = SimpleNamespace(verdict="no_gap")
    monkeypatch.setattr("flexros.gap.report.comparison.read_diagnosis", lambda file: read)
    with pytest.raises(InputError, match="found no gap; leave it out") as told:
        gap._refuse_missing(tmp_path / "patch.yaml")
    assert told.value.argument == "patch"
    read.verdict = "unknown_effect"
    with pytest.raises(InputError, match="unknown_effect"):
        gap._refuse_missing(tmp_path / "patch.yaml")
    gap._refuse_missing(tmp_path / "elsewhere" / "patch.yaml")  # the reader of the patch says that it is not there


def test_the_gap_before_of_a_log_of_servos_does_not_depend_on_the_patch(flexros, tmp_path: Path) -> None:
    robot, file = tmp_path / "robot.yaml", tmp_path / "stiffer.yaml"
    robot.write_text(SERVO, encoding="utf-8")
    write_log(replace(servo_log(), provenance={"import": {"files": ["run.csv"]}}), tmp_path / "log")
    effect = "{effect: servo_stiffness_error, location: motor_1, parameters: {relative: 0.5}}"
    file.write_text(f"robot: robot.yaml\neffects:\n  - {effect}\n", encoding="utf-8")
    alone = flexros("gap", str(tmp_path / "log"), "--model", str(robot), "--json")
    beside = flexros("gap", str(tmp_path / "log"), "--model", str(robot), "--patch", str(file), "--json")
    assert json.loads(alone.out)["before"] == json.loads(beside.out)["before"]
