"""Plants with laws of effects: the same bits everywhere, and nothing where an effect is switched off."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import compile_loop
from flexros.effects.kinds import bristle_friction
from flexros.errors import InputError
from flexros.scenario.batch import batch, whole_record
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario
from flexros.simulate.plant_model import PlantModel

ALL = [
    "coulomb_friction@motor_1:level=300,asymmetry=0.2",
    "viscous_friction@motor_1:coefficient=50,asymmetry=-0.3",
    "torque_ripple@motor_1:amplitude=20,order=6",
    "torque_ripple@motor_2:amplitude=0.05,order=12,proportional=true",
    "coulomb_friction@motor_2:level=80",
    "nonlinear_stiffness@body_1.ry:relative=0.4,knee=1e-3",
    "torque_saturation@motor_1:limit=2500",
    "torque_gain_error@motor_1:relative=0.05",
    "actuator_lag@motor_2:time_constant=0.0007",
    "presliding_friction@motor_2:level=60,extra=20,velocity=0.01,stiffness=1e7,damping=1e4",
    "friction_drift@motor_1:coulomb=50,viscous=100,time_constant=0.1",
    "encoder_eccentricity@motor_2:amplitude=1e-3,order=20",
    "encoder_quantization@motor_1:step=1e-5",
    "delay@motor_2:time=0.0003",
]


def experiment(*effects: str, **settings: object) -> Experiment:
    given = {
        "name": "mine",
        "robot": "e12",
        "duration": 0.3,
        "noise": True,
        "feedforward": {"method": "none"},
        "controller": {"kind": "pid", "kp": 1e5, "kd": 3e3},
        "disturbances": [{"kind": "pulse", "at": f"motor_{k}", "amplitude": 3000 / k, "width": 0.1} for k in (1, 2)],
        "plant": {"effects": list(effects), "values": {"delay": 0.0008}},
    }
    return Experiment.prepare(Scenario.model_validate({**given, **settings}))


@pytest.mark.slow
def test_stepped_plant_equals_the_run_to_the_last_bit() -> None:
    prepared = experiment(*ALL)
    log = closed_loop(prepared)
    assert log.joint_commands is not None
    assert log.tool_pose is not None
    plant = prepared.plant_in_time()
    for k, command in enumerate(log.joint_commands.effort):  # type: ignore[arg-type]
        assert np.array_equal(plant.measure(), log.joint_states.position[k])  # type: ignore[index]
        assert np.array_equal(plant.tool_pose()[:3], log.tool_pose.position[k])
        plant.advance(command)


@pytest.mark.slow
def test_every_law_changes_the_motion() -> None:
    runs = [closed_loop(experiment(*effects)).joint_states.position for effects in ([], *([one] for one in ALL))]
    for changed in runs[1:]:
        assert np.max(np.abs(changed - runs[0])) > 1e-6  # type: ignore[operator]


@pytest.mark.slow
def test_further_sweeps_over_frictions_need_one_pass_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bristles beside dry friction at the same motor begin a sweep where the one before ended."""
    frictions = (ALL[0], "presliding_friction@motor_1:level=200,extra=50,velocity=0.01,stiffness=1e6,damping=1e3")
    runs = []
    for passes in (0, 1, 20):
        monkeypatch.setattr(bristle_friction, "FURTHER_PASSES", passes)
        runs.append(closed_loop(experiment(*frictions)).joint_states.position)
    none, one, many = runs
    assert np.max(np.abs(one - many)) < 1e-12 < np.max(np.abs(none - many))  # type: ignore[operator]


def test_neutral_effects_leave_the_run_as_it_is_to_the_last_bit() -> None:
    neutral = [
        "coulomb_friction@motor_1:level=0,asymmetry=0.2",
        "viscous_friction@motor_1:asymmetry=-0.3",
        "torque_ripple@motor_2:amplitude=0,order=6",
        "nonlinear_stiffness@body_1.ry:relative=0,knee=1e-3",
    ]
    with_them, without = (closed_loop(experiment(*effects)) for effects in (neutral, []))
    assert np.array_equal(with_them.joint_states.position, without.joint_states.position)  # type: ignore[arg-type]


@pytest.mark.slow
def test_batch_over_parameters_of_robot_and_effects_equals_single_runs() -> None:
    prepared = experiment(*ALL)
    values = {
        "torque_ripple@motor_1.amplitude": [0.0, 5.0, 20.0],
        "body_3.mass": [200.0, 210.0, 190.0],
        "coulomb_friction@motor_1.level": [300.0, 0.0, 500.0],
    }
    records = batch(prepared, whole_record, values=values)
    for run in range(3):
        ripple, mass, level = (numbers[run] for numbers in values.values())
        effects = [
            f"coulomb_friction@motor_1:level={level},asymmetry=0.2",
            ALL[1],
            f"torque_ripple@motor_1:amplitude={ripple},order=6",
            *ALL[3:],
        ]
        plant = {"effects": effects, "values": {"delay": 0.0008, "body_3.mass": mass}}
        single = closed_loop(experiment(plant=plant))
        np.testing.assert_allclose(records[run].encoder, single.joint_states.position, atol=1e-12)  # type: ignore[arg-type]


def test_state_of_the_robot_excludes_the_states_of_effects() -> None:
    assert experiment(*ALL).plant_in_time().state.shape == (10,)


def test_plant_hash_tells_the_laws() -> None:
    hashes = {experiment(*effects).provenance()["plant_hash"] for effects in ([], ALL[:1], ALL[:2])}
    assert len(hashes) == 3


def test_unknown_parameter_is_refused_with_the_names_of_laws_among_those_allowed() -> None:
    prepared = experiment(ALL[0])
    with pytest.raises(InputError, match=r"did you mean 'coulomb_friction@motor_1.level'"):
        PlantModel(prepared.plant, prepared.laws, ["coulomb_friction@motor_1.levle"])


def test_value_that_the_effect_does_not_allow_is_refused_before_the_batch() -> None:
    with pytest.raises(InputError, match=r"run 1 of the batch: coulomb_friction@motor_1: level is -1, but"):
        batch(experiment(ALL[0]), whole_record, values={"coulomb_friction@motor_1.level": [1.0, -1.0]})


@pytest.mark.slow
def test_machine_code_agrees_with_the_virtual_machine() -> None:
    prepared = experiment(*ALL, noise=False)
    functions = prepared.plant_model.functions(prepared.scenario.controller.function(prepared.loop_context))
    encoders = []
    for engine in ("machine_code", "virtual_machine"):
        kernel = compile_loop(functions, sample_time=prepared.sample_time, engine=engine)
        start = kernel.initial_state(
            prepared.plant_model.start(prepared.start_state),
            prepared.scenario.controller.initial_state(prepared.loop_context),
        )
        disturbance = prepared.signals(0).disturbance.rows(0, 400)
        inputs = LoopInputs(reference=prepared.reference_signal[:400], disturbance=disturbance, gains=prepared.gains)
        encoders.append(kernel.run(start, 400, inputs).encoder)
    assert np.max(np.abs(encoders[0])) > 1e-3
    np.testing.assert_allclose(encoders[0], encoders[1], rtol=0, atol=1e-11)


def test_delay_of_one_motor_shifts_its_commands_alone() -> None:
    """A delay of whole samples at one motor is the run in which that motor's commands come later."""
    late, prompt = experiment("delay@motor_2:time=0.0015"), experiment()
    T, torque = prompt.sample_time, np.random.default_rng(0).normal(size=(60, 2)) * 500
    plants = [one.plant_in_time() for one in (late, prompt)]
    shift = round(0.0015 / T)
    assert shift == pytest.approx(0.0015 / T)
    before = prompt.start_torque
    for k in range(60):
        plants[0].advance(torque[k])
        plants[1].advance([torque[k, 0], torque[k - shift, 1] if k >= shift else before[1]])
        np.testing.assert_allclose(plants[0].state, plants[1].state, atol=1e-12)


def test_delays_of_all_and_of_one_motor_add_up() -> None:
    model = experiment("delay@motor_2:time=0.0002", "delay@all:time=0.001", "delay@motor_2:time=0.0001").plant_model
    assert model.delay == pytest.approx((0.0018, 0.0021))
    assert experiment("delay@all:time=0.001").plant_model.delay == pytest.approx(0.0018)


def test_start_is_the_steady_state_of_past_commands() -> None:
    """Gravity is held from the first instant on, behind saturation, gain and lag."""
    effects = ["actuator_lag@motor_1:time_constant=0.01", "torque_gain_error@motor_1:relative=0.5"]
    prepared = experiment(*effects, robot="elbow", disturbances=[], noise=False, plant={"effects": effects})
    model, state = prepared.plant_model, prepared.start_state
    torque = prepared.plant.holding_torque(state)[0]
    assert model.start(state)[-3:] == pytest.approx([torque, torque, 0.0])
    assert model.start(state, np.array([3.0, 0.0]))[-3:] == pytest.approx([4.5, 4.5, 0.0])


def test_free_parameters_of_a_start_have_the_values_they_were_given_with() -> None:
    effects = ["actuator_lag@motor_1:time_constant=0.01", "torque_gain_error@motor_1:relative=0.5"]
    prepared = experiment(robot="elbow", disturbances=[], noise=False, plant={"effects": effects})
    names = ["body_2.mass", "torque_gain_error@motor_1.relative"]
    free = PlantModel(prepared.plant, prepared.laws, names)
    assert free.nominal_values == pytest.approx([prepared.plant.parameters["body_2.mass"].value, 0.5])
    np.testing.assert_allclose(free.start(prepared.start_state), prepared.plant_model.start(prepared.start_state))
