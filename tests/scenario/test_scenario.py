"""Scenarios: loading, changing, and one clear sentence for everything that is wrong."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

import pytest
from pydantic import BaseModel, ValidationError

import flexros
from flexros.cli.commands.run import changed_scenario
from flexros.control.context import LoopContext
from flexros.control.pid import Pid
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.scenario import Scenario, load_scenario, scenario_names
from flexros.simulate.disturbance import Step

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.slow

HEAD = "robot: e12\nduration: 1\n"
MINIMAL = HEAD + "controller: {kind: pid, kp: 1e5}\n"
BUILT_IN = (
    "circle_dae",
    "circle_dae2",
    "circle_fj",
    "circle_pd",
    "elbow_moves",
    "regulator_four_mass",
    "six_axis_moves",
    "smooth_dae",
    "smooth_dae2",
    "two_mass_step",
)


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_built_in_scenarios_are_those_promised() -> None:
    assert set(BUILT_IN) <= set(scenario_names())


@pytest.mark.parametrize("name", scenario_names())
def test_built_in_scenario_loads_is_described_and_fits_its_robot(name: str) -> None:
    scenario = load_scenario(name)
    robot = load_robot(scenario.robot)
    assert scenario.name == name
    assert len(scenario.description) > 40
    scenario.controller.gains(LoopContext(robot, robot.sample_time))


@pytest.mark.parametrize("name", scenario_names())
def test_settings_make_the_same_scenario_again(name: str) -> None:
    scenario = load_scenario(name)
    again = Scenario.model_validate(scenario.settings())
    assert again == scenario
    assert again.digest() == scenario.digest()


@pytest.mark.parametrize("name", ["circle_pd", "circle_dae", "circle_dae2"])
def test_circle_scenarios_have_the_published_feedback(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.controller == Pid(kp=135000.0, kd=9000.0)
    assert not scenario.noise


def test_every_key_is_described() -> None:
    def check(model: type[BaseModel]) -> None:
        for name, field in model.model_fields.items():
            assert field.description, f"{model.__name__}.{name} lacks a description"

    check(Scenario)
    check(Step)


def test_defaults_of_a_minimal_file(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, MINIMAL))
    assert (scenario.name, scenario.robot, scenario.sample_time, scenario.noise) == ("mine", "e12", None, True)


def test_scenario_is_frozen() -> None:
    with pytest.raises(ValidationError):
        load_scenario("circle_pd").seed = 2  # type: ignore[misc]


def test_robot_file_is_relative_to_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text("name: mine\n", encoding="utf-8")
    path = write(tmp_path, MINIMAL.replace("e12", "robot.yaml"))
    assert load_scenario(path).robot == str(tmp_path / "robot.yaml")


def test_values_are_set_by_dotted_keys() -> None:
    scenario = load_scenario("circle_dae").with_values(
        {"sample_time": 0.001, "plant.values.body_3.mass": 190, "controller.kp": 1e5, "seed": 7}
    )
    assert scenario.sample_time == 0.001
    assert scenario.plant.values == {"body_3.mass": 190.0}
    assert scenario.controller == Pid(kp=1e5, kd=9000.0)
    assert scenario.seed == 7
    assert load_scenario("circle_dae").plant.values == {}


def test_values_within_lists_are_set_by_index() -> None:
    scenario = load_scenario("regulator_four_mass").with_values({"disturbances.0.amplitude": 1.5})
    first = scenario.disturbances[0]
    assert isinstance(first, Step)
    assert first.amplitude == 1.5


def test_effects_of_the_plant_are_kept_as_written(tmp_path: Path) -> None:
    text = "payload_error@tool:relative=0.05"
    scenario = load_scenario(write(tmp_path, MINIMAL + f"plant: {{effects: ['{text}']}}\n"))
    assert scenario.plant.effects == (text,)
    assert scenario.settings()["plant"] == {"effects": [text]}


def test_the_command_line_and_python_choose_alike() -> None:
    settings, effect = {"seed": 4, "duration": 0.002}, "delay@all:time=0.001"
    texts = [f"{key}={value}" for key, value in settings.items()]
    scenario = changed_scenario("two_mass_step", "four_mass", texts, [effect], 7)
    run = flexros.run("two_mass_step", model="four_mass", settings=settings, effects=[effect], seed=7)
    assert scenario == run.scenario
    assert (scenario.robot, scenario.seed, scenario.plant.effects[-1:]) == ("four_mass", 7, (effect,))


def test_digest_tells_effects_but_not_that_there_are_none() -> None:
    scenario = load_scenario("circle_dae")
    assert scenario.with_values({"plant.effects": []}).digest() == scenario.digest()
    assert scenario.with_values({"plant.effects": ["delay@all:time=0.001"]}).digest() != scenario.digest()


def test_digest_tells_an_identification_but_not_that_there_is_none() -> None:
    scenario = load_scenario("circle_dae")
    settings = scenario.model_dump(
        mode="json", exclude={"name", "description", "identification", "diagnosis", "feedforward_model"}
    )
    del settings["plant"]["effects"]
    text = json.dumps(settings, sort_keys=True, separators=(",", ":"))
    assert scenario.digest() == hashlib.sha256(text.encode()).hexdigest()
    identify = load_scenario("identify_e12")
    assert identify.with_values({"identification.blocks": 3}).digest() != identify.digest()


@pytest.mark.parametrize("key", ["duration", "trajectory"])
def test_identification_excludes_trajectory_and_duration(key: str) -> None:
    values = {"duration": 1.0, "trajectory": load_scenario("circle_dae").settings()["trajectory"]}
    with pytest.raises(InputError, match=f"has identification and {key}, allowed is one of them, .* remove {key}"):
        load_scenario("identify_e12").with_values({key: values[key]})


def test_digest_changes_with_the_settings() -> None:
    scenario = load_scenario("circle_dae")
    assert scenario.with_values({"seed": 2}).digest() != scenario.digest()
    assert len(scenario.digest()) == 64


def test_digest_does_not_change_with_name_description_or_defaults_spelled_out() -> None:
    scenario = load_scenario("circle_dae")
    spelled_out = scenario.with_values({"name": "other", "description": "", "substeps": 1, "controller.ki": 0})
    assert spelled_out.digest() == scenario.digest()


def test_unknown_scenario_offers_the_nearest() -> None:
    with pytest.raises(InputError, match=r"unknown scenario 'circle_da'.*did you mean 'circle_dae'\?.* circle_pd"):
        load_scenario("circle_da")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (MINIMAL + "sed: 3\n", r"mine\.yaml: unknown key 'sed': did you mean 'seed'\?"),
        ("duration: 1\ncontroller: {kind: pid, kp: 1}\n", r"mine\.yaml: key 'robot' is missing"),
        (HEAD, r"mine\.yaml: key 'controller' is missing"),
        (MINIMAL + "sample_time: .nan\n", r"mine\.yaml: key 'sample_time' is nan"),
        (MINIMAL + "sample_time: -1\n", r"mine\.yaml: key 'sample_time' is -1, but input should be greater than 0"),
        (MINIMAL + "plant: {values: {body_3.mass: .nan}}\n", r"mine\.yaml: key 'plant\.values.*nan.*finite"),
        (MINIMAL + "seed: -1\n", r"mine\.yaml: key 'seed' is -1"),
        (
            MINIMAL + "plant: {effects: ['delay@all:time=0.001', payload_error]}\n",
            r"mine\.yaml: key 'plant\.effects\[1\]': effect is 'payload_error', but must be NAME@LOCATION",
        ),
        (
            MINIMAL + "plant: {effects: ['payload@tool:relative=1']}\n",
            r"key 'plant\.effects\[0\]': unknown effect 'payload' in effect: did you mean 'payload_error'\?",
        ),
        (MINIMAL + "plant: {effects: ['delay@all:time=2']}\n", r"effect delay: key 'time' is '2', but .* less than"),
        (MINIMAL + "plant: {effects: delay@all}\n", r"key 'plant\.effects' is 'delay@all', but .* correct the value"),
        (MINIMAL + "model: {effects: []}\n", r"unknown key 'model\.effects': allowed are values"),
        (MINIMAL + "plant: {vallues: {}}\n", r"unknown key 'plant\.vallues': did you mean 'values'\?"),
        (
            "robot: e12\nduration: 1\ncontroller: {kind: pdi, kp: 1}\n",
            r"unknown kind 'pdi' in controller: did you mean 'pid'\?",
        ),
        (MINIMAL.replace("kp:", "kd: 1, kpp: 2, kp:"), r"mine\.yaml: key 'controller': .*'kpp': did you mean 'kp'\?"),
        (MINIMAL.replace("1e5", ".nan"), r"mine\.yaml: key 'controller': .*key 'kp.*nan.*finite"),
        (
            "robot: e12\nduration: 1\ncontroller: pid\n",
            r"mine\.yaml: key 'controller': is 'pid', but must be a mapping",
        ),
        (MINIMAL + "disturbances: [{kind: step, at: motor_1}]\n", r"disturbances\[0\].*amplitude' is missing"),
        (
            MINIMAL + "disturbances: [{kind: stp, at: motor_1}]\n",
            r"disturbances\[0\].*'step', 'pulse', 'chirp', 'noise'",
        ),
        (MINIMAL.replace("duration: 1", ""), r"mine\.yaml: the scenario has neither trajectory nor duration; add dur"),
        (MINIMAL + "seed: [\n", r"mine\.yaml, line \d+: broken YAML"),
    ],
)
def test_invalid_scenario_is_refused_with_one_sentence(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        load_scenario(write(tmp_path, text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("sampletime", 1.0, r"scenario circle_pd: unknown key 'sampletime': did you mean 'sample_time'\?"),
        ("seed.x", 1, r"key seed\.x: 'x' is within .*, which has no keys"),
        ("disturbances.3.amplitude", 1, r"key disturbances\.3\.amplitude: there is no entry 3, allowed are none"),
        ("duration", "long", r"scenario circle_pd: key 'duration' is 'long'"),
    ],
)
def test_wrong_changes_name_their_key(key: str, value: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario("circle_pd").with_values({"seed": 1, key: value})


def test_name_that_no_file_can_have_is_refused() -> None:
    with pytest.raises(InputError, match="key 'name' is 'a/b'"):
        load_scenario("circle_pd").with_values({"name": "a/b"})
