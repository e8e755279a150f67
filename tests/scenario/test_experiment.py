"""Scenarios made ready to run."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.errors import InputError, RunError
from flexros.feedforward.time_stepping import stepping as stepping_module
from flexros.feedforward.time_stepping.compiled import CompiledStepper
from flexros.scenario.experiment import Experiment, bytes_per_sample
from flexros.scenario.scenario import Scenario, load_scenario

pytestmark = pytest.mark.slow


def scenario(**settings: object) -> Scenario:
    given = {"name": "mine", "robot": "e12", "duration": 0.1, "controller": {"kind": "pid", "kp": 1e5}}
    return Scenario.model_validate({**given, "feedforward": {"method": "none"}, **settings})


def test_circle_has_the_samples_of_its_trajectory() -> None:
    experiment = Experiment.prepare(load_scenario("circle_pd"))
    assert experiment.sample_time == 5e-4
    assert experiment.n_samples == 762  # 0.380826 s, the last sample at 0.3805 s
    assert experiment.reference_signal.shape == (762, 6)
    np.testing.assert_allclose(experiment.reference.output[0], [2.146403786951, -0.354624247994], atol=1e-11)


def test_without_feedforward_torque_only_the_motor_positions_are_followed() -> None:
    alone, helped = (Experiment.prepare(load_scenario(name)).reference for name in ("circle_pd", "circle_dae"))
    assert np.array_equal(alone.motor_position, helped.motor_position)
    assert not np.any(alone.torque)
    assert np.any(helped.torque)


def test_without_trajectory_the_start_is_held() -> None:
    experiment = Experiment.prepare(scenario(start=[0.1, 0.4, 0.0]))
    assert experiment.n_samples == 201
    assert np.array_equal(experiment.reference.motor_position, np.tile([0.1, 0.4], (201, 1)))
    np.testing.assert_allclose(experiment.start_state, [0.1, 0.4, 0, 0.1, 0.4, 0, 0, 0, 0, 0], atol=1e-12)


def test_duration_may_be_longer_than_the_trajectory() -> None:
    experiment = Experiment.prepare(load_scenario("circle_fj").with_values({"duration": 0.5}))
    assert experiment.n_samples == 1001
    reference = experiment.reference.motor_position
    np.testing.assert_allclose(reference[-1], reference[0], atol=1e-12)


def test_values_of_model_reach_both_robots_and_those_of_plant_only_one() -> None:
    experiment = Experiment.prepare(
        scenario(model={"values": {"body_1.mass": 110}}, plant={"values": {"body_3.mass": 190}})
    )
    masses = [
        [robot.parameters[f"body_{n}.mass"].value for n in (1, 3)] for robot in (experiment.nominal, experiment.plant)
    ]
    assert masses == [[110.0, 200.0], [110.0, 190.0]]


def test_start_is_at_rest_under_gravity_on_the_first_reference() -> None:
    experiment = Experiment.prepare(load_scenario("elbow_moves"))
    model, x = experiment.plant.model, experiment.start_state
    rate = np.asarray(model.derivative(x, experiment.start_torque, np.zeros(6), model.parameter_values)).ravel()
    np.testing.assert_allclose(rate, 0.0, atol=1e-9)
    np.testing.assert_allclose(x[2:4], experiment.reference.motor_position[0], atol=1e-12)


def test_heavier_plant_starts_deflected_but_with_the_same_motor_positions() -> None:
    nominal = Experiment.prepare(load_scenario("elbow_moves"))
    heavy = Experiment.prepare(load_scenario("elbow_moves").with_values({"plant.values.body_2.mass": 60}))
    np.testing.assert_allclose(heavy.start_state[2:4], nominal.start_state[2:4], atol=1e-12)
    assert np.all(np.abs(heavy.start_state[:2] - nominal.start_state[:2]) > 1e-4)


def test_provenance_is_plain_data_with_hashes_and_versions() -> None:
    provenance = Experiment.prepare(load_scenario("circle_dae")).provenance()
    again = json.loads(json.dumps(provenance, allow_nan=False))
    assert again["scenario"]["controller"]["kp"] == 135000.0
    assert again["scenario_hash"] == load_scenario("circle_dae").digest()
    assert again["model_hash"] == again["plant_hash"]
    assert set(again["versions"]) == {"python", "flexros", "casadi", "llvmlite", "numpy", "scipy"}


def test_plant_hash_tells_a_changed_plant() -> None:
    provenance = Experiment.prepare(scenario(plant={"values": {"body_3.mass": 190}})).provenance()
    assert provenance["model_hash"] != provenance["plant_hash"]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"robot": "e13"}, r"unknown robot 'e13'.*did you mean 'e12'\?"),
        (
            {"plant": {"values": {"body_9.mass": 1}}},
            r"'body_9\.mass' in scenario mine, key plant\.values: ",
        ),
        ({"plant": {"values": {"body_3.mass": -1}}}, r"scenario mine, key plant\.values.*-1"),
        ({"start": [0.1]}, r"scenario mine, key start: 1 arm coordinates were given, but robot e12 has 3"),
        ({"controller": {"kind": "pid", "kp": [1, 2, 3]}}, r"scenario mine: controller\.kp has 3 values"),
        (
            {"disturbances": [{"kind": "step", "at": "motor_9", "amplitude": 1}]},
            r"scenario mine: unknown location 'motor_9' in disturbances\[0\]\.at",
        ),
        (
            {
                "duration": None,
                "feedforward": {"method": "dae", "output": "toool"},
                "trajectory": {
                    "path": {"type": "circle", "radius": 0.01},
                    "time_law": {"type": "quintic", "duration": 1},
                },
            },
            r"scenario mine, key feedforward\.output: unknown output of robot e12 'toool': did you mean 'tool'\?",
        ),
        (
            {"duration": 1e6},
            r"scenario mine: 1e\+06 s .* are 2000000001 samples, which need some 1\.1e\+03 GB of memory with robot "
            r"e12, allowed are 4 GB; shorten",
        ),
        (
            {"plant": {"values": {"sample_time": 1e-3}}},
            r"scenario mine, key plant\.values: sample_time is given, but plant and controller share one sample time; "
            "set the scenario's key sample_time instead",
        ),
        (
            {"plant": {"effects": ["stiffness_error@body_9.ry:relative=0.1"]}},
            r"scenario mine, key plant\.effects: unknown location of stiffness_error on robot e12 'body_9\.ry'",
        ),
    ],
)
def test_impossible_scenario_is_refused_with_one_sentence(settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        Experiment.prepare(scenario(**settings))
    assert "\n" not in str(caught.value)


def test_circle_through_a_singularity_names_the_point() -> None:
    far = load_scenario("circle_pd").with_values({"trajectory.path.centre_from_start": [0.05, 0]})
    with pytest.raises(InputError, match=r"scenario circle_pd: .*passes a singularity.* t = 0\.\d+ s, .* % of move 1"):
        _ = Experiment.prepare(far).reference


def test_memory_is_bounded_in_bytes_not_in_samples() -> None:
    with pytest.raises(InputError, match=r"are 8000001 samples, which need some 4\.4 GB of memory with robot e12"):
        Experiment.prepare(scenario(duration=4000.0))
    assert Experiment.prepare(scenario(duration=1000.0)).n_samples == 2_000_001
    six_axis = {"robot": "six_axis", "controller": {"kind": "pid", "kp": 1e3}}
    with pytest.raises(InputError, match=r"some 5\.\d GB of memory with robot six_axis"):
        Experiment.prepare(scenario(**six_axis, duration=2000.0))


def test_bytes_per_sample_cover_the_arrays_that_are_held() -> None:
    experiment = Experiment.prepare(load_scenario("circle_dae"))
    reference = experiment.reference
    arrays = [getattr(reference, field.name) for field in fields(reference)]
    held = sum(array.nbytes for array in (*arrays, experiment.reference_signal)) / experiment.n_samples
    assert held < bytes_per_sample(experiment.nominal, experiment.trajectory.n_out) < 4 * held


def test_identification_needs_little_more_memory_than_its_reference() -> None:
    experiment = Experiment.prepare(load_scenario("identify_e12"))
    reference = experiment.reference
    arrays = [getattr(reference, field.name) for field in fields(reference)]
    held = sum(array.nbytes for array in (*arrays, experiment.reference_signal)) / experiment.n_samples
    assert held < bytes_per_sample(experiment.nominal, 2, planned=True) < 2 * held


def test_effects_change_the_plant_after_its_values() -> None:
    experiment = Experiment.prepare(
        scenario(plant={"values": {"body_3.mass": 100}, "effects": ["payload_error@tool:relative=0.1"] * 2})
    )
    assert experiment.nominal.parameters["body_3.mass"].value == 200.0
    assert experiment.plant.parameters["body_3.mass"].value == pytest.approx(121.0)
    assert experiment.provenance()["scenario"]["plant"]["effects"] == ["payload_error@tool:relative=0.1"] * 2


def test_effect_equals_the_same_parameter_value() -> None:
    by_effect, by_value = (
        Experiment.prepare(scenario(plant=plant)).plant.model_hash
        for plant in ({"effects": ["delay@all:time=0.001"]}, {"values": {"delay": 0.001}})
    )
    assert by_effect == by_value


def test_feedforward_that_fails_at_rest_names_the_point(monkeypatch: pytest.MonkeyPatch) -> None:
    def give_up(
        stepper: CompiledStepper, state: FloatArray, outputs: FloatArray, tolerance: FloatArray
    ) -> stepping_module.SteppingResult:
        n = len(outputs)
        return stepping_module.SteppingResult(
            state, np.zeros((n, 5)), np.zeros((n, 5, 2)), np.zeros(n, dtype=np.int64), 3
        )

    monkeypatch.setattr(CompiledStepper, "advance", give_up)
    experiment = Experiment.prepare(scenario(feedforward={"method": "dae"}))
    with pytest.raises(RunError, match=r"found no solution at t = 0\.0015 s, 0\.0 % of move 1 .* point \("):
        _ = experiment.reference
