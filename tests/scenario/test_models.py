"""The robots of a scenario, with patches among them."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.experiment import Experiment
from flexros.scenario.models import ScenarioModels
from flexros.scenario.scenario import Scenario, load_scenario

HEAVIER = "robot: e12\neffects: [{effect: payload_error, location: tool, parameters: {relative: 0.1}}]\n"
RUBBING = "robot: e12\neffects: [{effect: coulomb_friction, location: motor_1, parameters: {level: 20}}]\n"


def scenario(**settings: object) -> Scenario:
    given = {"name": "mine", "robot": "e12", "duration": 0.1, "controller": {"kind": "pid", "kp": 1e5}}
    return Scenario.model_validate({**given, "feedforward": {"method": "dae"}, **settings})


def written(folder: Path, text: str) -> str:
    path = folder / "patch.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def mass(models: ScenarioModels) -> list[float]:
    return [one.robot.parameters["body_3.mass"].value for one in (models.nominal, models.known, models.plant)]


def test_a_patch_as_robot_is_in_the_model_and_in_the_plant(tmp_path: Path) -> None:
    patch = written(tmp_path, HEAVIER)
    assert mass(ScenarioModels.of(scenario(robot=patch))) == pytest.approx([220.0] * 3)
    more = scenario(robot=patch, plant={"effects": ["payload_error@tool:relative=0.1"]})
    assert mass(ScenarioModels.of(more)) == pytest.approx([220.0, 220.0, 242.0])


def test_a_patch_as_feedforward_model_leaves_nominal_robot_and_plant(tmp_path: Path) -> None:
    hidden = scenario(
        feedforward_model=written(tmp_path, HEAVIER), plant={"effects": ["payload_error@tool:relative=0.2"]}
    )
    assert mass(ScenarioModels.of(hidden)) == pytest.approx([200.0, 220.0, 240.0])


def test_laws_of_patch_and_plant_stand_side_by_side(tmp_path: Path) -> None:
    both = scenario(robot=written(tmp_path, RUBBING), plant={"effects": ["coulomb_friction@motor_1:level=5"]})
    models = ScenarioModels.of(both)
    assert [law.name for law in models.known.laws] == ["coulomb_friction@motor_1"]
    assert [law.name for law in models.plant.laws] == ["coulomb_friction@motor_1", "coulomb_friction@motor_1#2"]


def test_values_replace_those_of_the_file_before_all_effects(tmp_path: Path) -> None:
    lighter = scenario(
        robot=written(tmp_path, HEAVIER), model={"values": {"body_3.mass": 100}}, plant={"values": {"body_3.mass": 50}}
    )
    assert mass(ScenarioModels.of(lighter)) == pytest.approx([110.0, 110.0, 55.0])


def test_provenance_tells_the_robots_apart(tmp_path: Path) -> None:
    plain = ScenarioModels.of(scenario()).provenance()
    assert plain == {"model_hash": load_robot("e12").model_hash, "plant_hash": load_robot("e12").model_hash}
    as_robot = ScenarioModels.of(scenario(robot=written(tmp_path, RUBBING))).provenance()
    assert as_robot["model_hash"] == as_robot["plant_hash"] != plain["model_hash"]
    assert as_robot["model_effects"] == ["coulomb_friction@motor_1:level=20.0,asymmetry=0.0"]
    known = ScenarioModels.of(scenario(feedforward_model=written(tmp_path, RUBBING))).provenance()
    assert known["feedforward_hash"] == as_robot["model_hash"]
    assert {"model_hash": known["model_hash"], "plant_hash": known["plant_hash"]} == plain
    assert known["feedforward_effects"] == as_robot["model_effects"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("e13", r"scenario mine, key feedforward_model: unknown robot 'e13'.*did you mean 'e12'\?"),
        (
            "four_mass",
            r"scenario mine, key feedforward_model: robot four_mass has 1 motor, stated on the motor side of the gear, "
            r"but the scenario's robot e12 has 2 motors, stated on the arm side of the gear; give a model of the same",
        ),
    ],
)
def test_a_feedforward_model_that_does_not_fit_is_named(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        Experiment.prepare(scenario(feedforward_model=name))
    assert "\n" not in str(caught.value)


def test_a_patch_is_found_next_to_the_scenario(tmp_path: Path) -> None:
    written(tmp_path, HEAVIER)
    text = (
        "robot: e12\nfeedforward_model: patch.yaml\nduration: 0.1\nfeedforward: {method: none}\n"
        "controller: {kind: pid, kp: 1}\n"
    )
    (tmp_path / "mine.yaml").write_text(text)
    assert mass(ScenarioModels.of(load_scenario(tmp_path / "mine.yaml")))[1] == pytest.approx(220.0)


def test_digest_tells_a_feedforward_model() -> None:
    plain = load_scenario("circle_dae")
    assert plain.with_values({"feedforward_model": "e12"}).digest() != plain.digest()
