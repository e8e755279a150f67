"""Predictors: effects that are fitted act as those that are known, and errors without gap are white noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.gap.candidates.candidate import Candidate, free_parameter
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.predictor import LANES, Predictor
from flexros.prediction.observer import observer_gain
from flexros.robot import load_robot
from flexros.simulate.plant_model import PlantModel
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, encoded, predictor_of, record_of

pytestmark = pytest.mark.slow

N = 4000


def innovations(predictor: Predictor, theta: FloatArray | list[float], **changes: object) -> FloatArray:
    """Prediction errors of the first two seconds of a log without effects."""
    data = data_of()
    record = replace(record_of().part(0, N), **changes)
    return predictor.predict(np.array(theta)[:, None], record, data.gain, data.initial_state).innovation[:, :, 0]


def test_errors_of_the_true_model_are_noise() -> None:
    data, nothing = data_of(), predictor_of()
    residual = data.residuals(nothing, np.zeros((0, 1)))[:, 0]
    assert residual @ residual / data.n_values == pytest.approx(1.0, abs=4 * np.sqrt(2 / data.n_values))
    counted = residual[residual != 0.0]
    assert abs(np.corrcoef(counted[1:], counted[:-1])[0, 1]) < 0.05


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("coulomb_friction@motor_1", {"level": 0.05}),
        ("backlash@motor_1", {"gap": 1e-3}),
        ("viscous_friction@motor_1", {"coefficient": 1e-3, "asymmetry": 0.2}),
        ("stiffness_error@body_2.rz", {"relative": -0.1}),
        ("motor_inertia_error@motor_1", {"relative": 0.05}),
    ],
)
def test_a_candidate_with_its_numbers_predicts_as_the_same_effect_that_is_known(
    effect: str, values: dict[str, float]
) -> None:
    candidate = candidates_of()[effect]
    text = effect + ":" + ",".join(f"{name}={value!r}" for name, value in values.items())
    known = place_effects(ROBOT, [parse_effect(text, "test")])
    expected = innovations(predictor_of(model=RobotWithEffects(known.robot, known.laws)), [])
    found = innovations(predictor_of(candidate), encoded(candidate, **values))
    assert np.std(expected - innovations(predictor_of(), [])) > 1e-6
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_effects_add_up() -> None:
    names = {"coulomb_friction@motor_1": {"level": 0.05}, "stiffness_error@body_2.rz": {"relative": -0.1}}
    pair = [candidates_of()[name] for name in names]
    theta = [number for one, values in zip(pair, names.values(), strict=True) for number in encoded(one, **values)]
    known = place_effects(
        ROBOT,
        [parse_effect(f"{name}:{key}={value}", "test") for name, one in names.items() for key, value in one.items()],
    )
    expected = innovations(predictor_of(model=RobotWithEffects(known.robot, known.laws)), [])
    np.testing.assert_allclose(innovations(predictor_of(*pair), theta), expected, atol=1e-12)
    assert predictor_of(*pair).values(np.array(theta)) == [
        {name: pytest.approx(value) for name, value in one.items()} for one in names.values()
    ]


@pytest.mark.parametrize(
    ("effect", "size"),
    [
        ("actuator_lag@motor_1", "time_constant"),
        ("backlash@motor_1", "gap"),
        ("coulomb_friction@motor_1", "level"),
        ("delay@all", "time"),
        ("hysteresis@motor_1", "level"),
    ],
)
def test_the_smaller_an_effect_the_nearer_it_is_to_nothing(effect: str, size: str) -> None:
    """The gap of a backlash, far smaller than what a correction by noise moves, once changed the predictions a lot."""
    candidate, nothing = candidates_of()[effect], innovations(predictor_of(), [])
    typical = {one.name: one.starts[0] for one in candidate.free}

    def away(value: float) -> float:
        found = innovations(predictor_of(candidate), encoded(candidate, **{**typical, size: value}))
        return float(np.abs(found - nothing).max())

    lowest = next(one.low for one in candidate.free if one.name == size)
    assert away(lowest) < 0.05 * float(ROBOT.encoder_noise[0])


def test_what_saturates_is_cut_off_before_a_delay_by_part_of_a_sample() -> None:
    saturation, delay = (candidates_of()[name] for name in ("torque_saturation@motor_1", "delay@all"))
    torque = record_of().part(0, N).torque
    late = encoded(delay, time=2.4 * ROBOT.sample_time)
    limit = 0.5 * float(np.abs(torque).max())
    theta = [*encoded(saturation, limit=limit), *late]
    expected = innovations(predictor_of(delay), late, torque=np.clip(torque, -limit, limit))
    np.testing.assert_allclose(innovations(predictor_of(saturation, delay), theta), expected, atol=1e-15)
    assert np.abs(expected - innovations(predictor_of(delay), late)).max() > 1e-3


def test_a_delay_of_whole_samples_shifts_the_torque() -> None:
    candidate = candidates_of()["delay@all"]
    torque = record_of().part(0, N).torque
    late = np.vstack([np.repeat(torque[:1], 3, axis=0), torque[:-3]])
    found = innovations(predictor_of(candidate), encoded(candidate, time=3 * ROBOT.sample_time))
    np.testing.assert_allclose(found, innovations(predictor_of(), [], torque=late), atol=1e-8)


@pytest.mark.parametrize("samples", [0.05, 2.4])
def test_a_delay_that_is_fitted_is_one_that_is_known_even_of_noise(samples: float) -> None:
    """Torques of a controller are full of noise up to half the sampling rate, where one torque a sample is no delay."""
    time = samples * ROBOT.sample_time
    candidate, known = candidates_of()["delay@all"], ROBOT.with_values({"delay": ROBOT.delay + time})
    noise = np.random.default_rng(1).normal(size=(N, 1)) * np.std(record_of().torque)
    found = innovations(predictor_of(candidate), encoded(candidate, time=time), torque=noise)
    expected = innovations(predictor_of(model=RobotWithEffects(known, ())), [], torque=noise)
    np.testing.assert_allclose(found, expected, atol=1e-3 * float(ROBOT.encoder_noise[0]))


def test_measured_torque_acts_without_the_nominal_delay() -> None:
    """The nominal delay is one sample: without it, a torque that is one sample later does the same."""
    torque = record_of().part(0, N).torque
    late = np.vstack([torque[:1], torque[:-1]])
    behind = Predictor(MODEL, (), Tolerance(), ROBOT.sample_time, measured_torque=True)
    assert pytest.approx(ROBOT.sample_time) == ROBOT.delay
    np.testing.assert_allclose(innovations(behind, [], torque=late), innovations(predictor_of(), []), atol=1e-12)


def test_every_set_of_numbers_starts_from_its_own_rest() -> None:
    """An arm that carries more hangs deeper on the springs of its gears, and stays there."""
    elbow = load_robot("elbow")
    tolerance = Tolerance(("body_2.mass",), (0.1,))
    predictor = Predictor(RobotWithEffects(elbow, ()), (), tolerance, elbow.sample_time)
    heavy = elbow.with_values({"body_2.mass": elbow.parameters["body_2.mass"].value * float(np.exp(0.2))})
    near = elbow.equilibrium(motor_position=np.array([0.1, 0.2]))
    rest = PlantModel(heavy).rest(near)
    still = replace(
        record_of(),
        position=np.repeat(rest.state[None, elbow.n_arm : elbow.n_coordinates], N, axis=0),
        torque=np.repeat(rest.torque[None], N, axis=0),
        valid=np.ones(N, dtype=bool),
    )
    gain = observer_gain(elbow, elbow.sample_time, 1e-3, elbow.encoder_noise)
    theta = np.array([[2.0]])
    own, shared = (
        np.abs(predictor.predict(theta, still, gain, near, from_rest=from_rest).innovation[:, :, 0]).max()
        for from_rest in (True, False)
    )
    assert own < 1e-3 * elbow.encoder_noise.min()
    assert shared > elbow.encoder_noise.max()


def test_a_tolerated_number_moves_by_its_standard_deviation() -> None:
    name = "body_1.rz.stiffness"
    tolerant = predictor_of(tolerance=Tolerance((name,), (0.02,)))
    stiffer = ROBOT.with_values({name: ROBOT.parameters[name].value * np.exp(3 * 0.02)})
    expected = innovations(predictor_of(model=RobotWithEffects(stiffer, ())), [])
    assert (tolerant.n_effect, tolerant.n_fitted) == (0, 1)
    np.testing.assert_allclose(innovations(tolerant, [3.0]), expected, atol=1e-12)


def test_a_number_has_no_tolerance_beside_an_effect_that_is_an_error_of_it() -> None:
    """A spring 25 % too soft had become one 26.4 % too soft and 1.4 % too stiff, and a patch held the first alone."""
    names = ("body_2.rz.stiffness", "body_1.rz.stiffness")
    candidate = candidates_of()["stiffness_error@body_2.rz"]
    predictor = predictor_of(candidate, tolerance=Tolerance(names, (0.02, 0.02), directions=np.eye(2)))
    softer = encoded(candidate, relative=-0.25)
    expected = innovations(predictor, [*softer, 0.0, 0.0])
    np.testing.assert_array_equal(innovations(predictor, [*softer, 4.0, 0.0]), expected)
    assert np.abs(innovations(predictor, [*softer, 0.0, 4.0]) - expected).max() > 1e-6


def test_sets_of_numbers_are_predicted_side_by_side() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, data = predictor_of(candidate), data_of()
    thetas = np.log(np.geomspace(1e-3, 0.1, LANES))[None, :]
    record = record_of().part(0, N)
    together = predictor.predict(thetas, record, data.gain, data.initial_state).innovation
    for lane in (0, 3, LANES - 1):
        np.testing.assert_allclose(together[:, :, lane], innovations(predictor, thetas[:, lane]), atol=1e-15)


def test_slopes_are_the_derivatives_of_the_values() -> None:
    pair = [candidates_of()[name] for name in ("viscous_friction@motor_1", "stiffness_error@body_2.rz")]
    predictor = predictor_of(*pair)
    theta = np.array([*encoded(pair[0], coefficient=2e-3, asymmetry=0.3), *encoded(pair[1], relative=0.1)])

    def flat(at: FloatArray) -> FloatArray:
        return np.array([value for one in predictor.values(at) for value in one.values()])

    differences = [
        (flat(theta + step)[k] - flat(theta - step)[k]) / 2e-5 for k, step in enumerate(1e-5 * np.eye(len(theta)))
    ]
    np.testing.assert_allclose(predictor.slopes(theta), differences, rtol=1e-6)


def test_bounds_are_those_of_the_candidate_and_wide_for_what_is_tolerated() -> None:
    candidate = candidates_of()["stiffness_error@body_2.rz"]
    low, high = predictor_of(candidate, tolerance=Tolerance(("body_1.rz.stiffness",), (0.02,))).bounds
    assert (low[0], high[0]) == candidate.free[0].bounds
    assert low[1] <= -5.0
    assert high[1] >= 5.0


def test_a_prediction_ahead_is_the_motion_without_corrections() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, data, record = predictor_of(candidate), data_of(), record_of().part(0, N)
    theta = np.array(encoded(candidate, level=0.05))
    blind = replace(data.gain, gain=np.zeros_like(data.gain.gain))
    alone = predictor.predict(theta[:, None], record, blind, data.initial_state, record_states=True)
    assert alone.states is not None
    positions = record.position - alone.innovation[:, :, 0]
    starts = np.array([5, 800, 801, 1500, 1999, 2400, 2800, 3000, 3700])
    found = predictor.ahead(theta, record, alone.states[:, :, 0], starts, 200).positions
    np.testing.assert_allclose(found, positions[starts + 200], atol=1e-12)


def test_a_hypothesis_of_another_zero_begins_at_the_true_position() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    offset = Candidate(EncoderOffset, "motor_1", (free_parameter("offset", EncoderOffset.ranges["offset"], 1.0),))
    data, thetas = data_of(), np.array([offset.free[0].encode(0.02), offset.free[0].encode(-0.01)])[None]
    start = data.initial_state
    moved = predictor_of(offset).behind_encoders(start, thetas)
    rows = [ROBOT.motor_rows[0], ROBOT.gear_rows[0]]
    np.testing.assert_allclose(start[rows, None] - moved[rows], [[0.02, -0.01]] * len(rows), atol=1e-15)
    others = np.setdiff1d(np.arange(len(start)), rows)
    np.testing.assert_array_equal(moved[others], np.repeat(start[others, None], 2, axis=1))
    assert predictor_of(candidate).behind_encoders(start, thetas) is start
