"""Errors of the torques of a measured log under a hypothesis."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import RobotWithEffects, effects, place_effects
from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.motor_law import AbstractMotorLaw, AbstractMotorTorque
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.feedforward.compensation.motors import with_motor_laws
from flexros.feedforward.motion import Motion
from flexros.gap.candidates.candidate import Candidate, list_candidates
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.fit.estimates import covariance_of
from flexros.gap.fit.least_squares import fit
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.residuals.torque_errors import TorqueErrors, torque_errors
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.rigid.motion_estimate import decimate
from flexros.robot import Robot
from tests.gap.rigid_arm import COULOMB, INERTIA, VISCOUS, T, arm, motion, record_of_arm

DEVIATION = np.array([0.1, 0.05])
VALUES = {
    "coulomb_friction": {"level": COULOMB},
    "viscous_friction": {"coefficient": VISCOUS},
}


def with_rotors(factor: float = 1.0) -> Robot:
    return arm().with_values({f"motor_{k + 1}.inertia": factor * value for k, value in enumerate(INERTIA)})


@cache
def errors_of(offset: float = 0.0) -> TorqueErrors:
    found = torque_errors(record_of_arm(imported=True, offset=offset), model(), 0.0, DEVIATION)
    assert found is not None
    return found


def model() -> RobotWithEffects:
    return RobotWithEffects(with_rotors(), ())


@cache
def candidates() -> dict[str, Candidate]:
    scales = scales_of_motors(with_rotors(), record_of_arm(imported=True))
    return {one.name: one for one in list_candidates(with_rotors(), scales, measured=True)}


def takes_torque(candidate: Candidate) -> bool:
    """Return whether it is a torque at a motor in its motion."""
    return issubclass(candidate.effect, AbstractDryFriction | AbstractBristleFriction | AbstractMotorTorque)


def predictor_of(
    values: dict[str, dict[str, float]], tolerance: Tolerance | None = None
) -> tuple[Predictor, FloatArray]:
    """Return the predictor of effects at motors with some of their parameters free, and these, encoded."""
    chosen = []
    for name, numbers in values.items():
        one = candidates()[name]
        chosen.append(replace(one, free=tuple(free for free in one.free if free.name in numbers)))
    theta = [free.encode(values[one.name][free.name]) for one in chosen for free in one.free]
    tolerance = tolerance or Tolerance()
    predictor = Predictor(model(), tuple(chosen), tolerance, T, measured_torque=True)
    return predictor, np.array([*theta, *([0.0] * tolerance.n_free)])[:, None]


def friction() -> dict[str, dict[str, float]]:
    return {
        f"{effect}@motor_{k + 1}": {name: float(numbers[k]) for name, numbers in parameters.items()}
        for effect, parameters in VALUES.items()
        for k in range(2)
    }


def size_of(values: dict[str, dict[str, float]], of: TorqueErrors | None = None) -> FloatArray:
    """Return the rms of the errors of each motor [Nm]."""
    errors = (of or errors_of()).errors(*predictor_of(values))
    return np.asarray(DEVIATION * np.sqrt(np.mean(errors.reshape(2, -1) ** 2, axis=1)))


def test_the_true_friction_leaves_nearly_nothing() -> None:
    torque = np.std(record_of_arm(imported=True).torque, axis=0)
    assert np.all(size_of(friction()) < 0.01 * torque)
    assert np.all(size_of({}) > 0.1 * torque)


def test_each_error_is_of_its_own_motor_over_its_deviation() -> None:
    only_second = {name: numbers for name, numbers in friction().items() if name.endswith("motor_2")}
    first, second = size_of(only_second)
    assert second == pytest.approx(size_of(friction())[1])
    assert first == pytest.approx(size_of({})[0])


def test_errors_are_usually_those_of_most_rows() -> None:
    """A constant torque that is missing is all that is left; in a fifth of the rows a joint sticks."""
    of, (predictor, thetas) = errors_of(), predictor_of(friction())
    torque = of.torque + np.array([2.0, 0.0])
    torque[: len(torque) // 5] += 50.0
    first, second = replace(of, torque=torque).usual(predictor, thetas[:, 0])
    assert first == pytest.approx(1.4826 * 2.0, rel=0.02)
    assert second < 0.05


def test_more_inertia_leaves_more() -> None:
    """It leaves less of the errors of predicted positions, whatever their cause."""
    heavy = {**friction(), "motor_inertia_error@motor_1": {"relative": 3.0}}
    expected = 3.0 * INERTIA[0] * np.sqrt(np.mean(motion()[2, :, 0] ** 2))
    assert size_of(heavy)[0] == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(("name", "numbers", "torque"), [
    ("torque_bias@motor_1", {"level": 2.0}, lambda q, v: np.full_like(q, -2.0)),
    ("coulomb_friction@motor_1", {"level": 2.0}, lambda q, v: 2.0 * np.sign(v)),
    ("viscous_friction@motor_1", {"coefficient": 1.0, "asymmetry": 0.5}, lambda q, v: v + 0.25 * np.abs(v)),
    ("presliding_friction@motor_1", {"level": 3.0, "stiffness": 1e4, "damping": 1.0}, lambda q, v: 3.0 * np.sign(v)),
])  # fmt: skip
def test_each_law_takes_its_torque(name: str, numbers: dict[str, float], torque: object) -> None:
    """The errors differ by the torque of the law along the motion, at the samples of the rows."""
    assert callable(torque)
    of = errors_of()
    without, with_law = (of.errors(*predictor_of(values)).reshape(2, -1) for values in ({}, {name: numbers}))
    q, v = motion()[0, :, 0], motion()[1, :, 0]
    expected = torque(q, v)
    taken = DEVIATION[0] * (without[0] - with_law[0])
    assert np.std(taken) == pytest.approx(np.std(expected), rel=0.05, abs=0.02)
    assert np.mean(taken) == pytest.approx(np.mean(expected), abs=0.05)
    np.testing.assert_allclose(with_law[1], without[1], atol=1e-9)


@pytest.mark.parametrize(("body", "relative"), [("body_1", -0.3), ("body_2", 0.2)])
def test_a_wrong_weight_takes_its_torque(body: str, relative: float) -> None:
    """As much as the weight of a body that is so much heavier; it was left out, and a payload stood for it."""
    of, robot = errors_of(), with_rotors()
    heavy = robot.with_values({f"{body}.mass": (1 + relative) * robot.parameters[f"{body}.mass"].value})
    without, with_law = (
        of.errors(*predictor_of(values)).reshape(2, -1).T
        for values in ({}, {f"gravity_error@{body}": {"relative": relative}})
    )
    q = robot.arm_from_gears(motion()[0])
    still = np.zeros_like(q)
    weights = [
        np.array([one.model.arm_inverse_dynamics(*rows, one.model.parameter_values) for rows in zip(q, still, still)])
        for one in (heavy, robot)
    ]
    expected = decimate((weights[0] - weights[1]).reshape(len(q), -1)[:, list(robot.gear_rows)], of.factor)
    taken = DEVIATION * (without - with_law)
    np.testing.assert_allclose(np.std(taken, axis=0), np.std(expected, axis=0), rtol=0.05)
    np.testing.assert_allclose(np.mean(taken, axis=0), np.mean(expected, axis=0), atol=0.05 * np.std(expected))


@pytest.mark.parametrize("name", sorted(name for name, one in candidates().items() if takes_torque(one)))
def test_each_law_takes_the_torque_that_the_feedforward_adds(name: str) -> None:
    """Two evaluations of the same laws: one for many sets of parameters, one with smoothed signs and own states."""
    of, robot, candidate = errors_of(), with_rotors(), candidates()[name]
    sizes = {free.name: float(np.sqrt(free.low * free.high)) for free in candidate.free}
    # bristles count as bent, and the sign is smoothed below a thousandth of the largest speed
    sizes |= {free.name: free.high for free in candidate.free if free.name in ("stiffness", "velocity")}
    position, velocity, torque, load = of.motion[1:].reshape(4, 2, -1).swapaxes(1, 2)
    own = INERTIA * np.gradient(velocity, T, axis=0)
    planned = Motion(position, position, velocity, torque, load + own, np.zeros_like(torque))
    placed = place_effects(robot, [candidate.placed(sizes)]).laws
    added = with_motor_laws(planned, robot, placed, T).torque - torque
    motor = robot.joint_names.index(candidate.location)
    expected = decimate(added, of.factor)[of.counts, motor]
    without, with_law = (of.errors(*predictor_of(values)).reshape(2, -1)[motor] for values in ({}, {name: sizes}))
    difference = DEVIATION[motor] * (without - with_law) - expected
    assert np.linalg.norm(difference) < 0.05 * np.linalg.norm(expected)


@pytest.mark.parametrize(("name", "shape"), [
    ("friction_curve@motor_1", {"speed"}),
    ("stribeck_friction@motor_1", {"velocity", "exponent"}),
    ("torque_curve@motor_1", {"low", "high"}),
    ("torque_ripple@motor_1", {"order", "phase"}),
])  # fmt: skip
def test_a_law_is_evaluated_along_the_motion_once_for_all_its_sizes(name: str, shape: set[str]) -> None:
    """Only a parameter of its shape asks for another evaluation."""
    kind = effects()[name.partition("@")[0]]
    assert issubclass(kind, AbstractMotorLaw)
    numbers = dict.fromkeys(kind.model_construct().parameter_values, 1.0)
    of = replace(errors_of())
    for size in (1.0, 2.0, 3.0):
        of._rows_of(kind, 0, tuple(value if key in shape else size for key, value in numbers.items()))
    assert of._parts_of.cache_info().misses == 1  # type: ignore[attr-defined]
    for key in shape:
        of._rows_of(kind, 0, tuple((numbers | {key: 2.0}).values()))
    assert of._parts_of.cache_info().misses == 1 + len(shape)  # type: ignore[attr-defined]


def test_a_gain_divides_the_torque_that_is_needed() -> None:
    """The errors stay those of the torque that is commanded: a small gain does not make them small."""
    of, (predictor, theta) = errors_of(), predictor_of({"torque_gain_error@motor_1": {"relative": 1.0}})
    needed = of.torque - DEVIATION * of.errors(*predictor_of({})).reshape(2, -1).T
    expected = (of.torque - needed / [2.0, 1.0]) / DEVIATION
    assert predictor.hypothesis[0].effect is TorqueGainError
    np.testing.assert_allclose(of.errors(predictor, theta)[:, 0], expected.T.ravel())


def test_a_delay_of_the_hypothesis_moves_the_torques() -> None:
    """Prepared with the delay of two samples, or with none and moved there."""
    prepared = torque_errors(record_of_arm(imported=True), model(), 2 * T, DEVIATION)
    assert prepared is not None
    values = {**friction(), "delay@all": {"time": 2 * T}}
    skipped = len(errors_of().torque) - len(prepared.torque)
    exact, moved = (of.errors(*predictor_of(values)).reshape(2, -1) for of in (prepared, errors_of()))
    stays = errors_of().errors(*predictor_of(friction())).reshape(2, -1)
    difference, size = (np.sqrt(np.mean((one[:, skipped:] - exact) ** 2)) for one in (moved, stays))
    assert difference < 0.2 * size


def test_friction_that_the_model_states_is_known() -> None:
    coulomb = [candidates()[name].placed(numbers) for name, numbers in friction().items() if name.startswith("coulomb")]
    stated = torque_errors(record_of_arm(imported=True), place_effects(with_rotors(), coulomb), 0.0, DEVIATION)
    assert stated is not None
    rest = {name: numbers for name, numbers in friction().items() if name.startswith("viscous")}
    np.testing.assert_allclose(size_of(rest, stated), size_of(friction()))


def test_a_log_without_motion_has_none() -> None:
    still = replace(record_of_arm(imported=True), position=np.zeros((4000, 2)))
    assert torque_errors(still, model(), 0.0, DEVIATION) is None


@cache
def weighed() -> FitData:
    data = fit_data(record_of_arm(imported=True), model(), DiagnosisSettings())
    return replace(data, torques=errors_of())


def test_all_errors_of_the_torques_count_as_much_as_the_prediction_errors() -> None:
    data, plain = weighed(), replace(weighed(), torques=None)
    assert data.n_values == 2 * plain.n_values
    predictor, theta = predictor_of({})
    residual = data.residuals(predictor, theta)[:, 0]
    np.testing.assert_array_equal(residual[: -errors_of().size], plain.residuals(predictor, theta)[:, 0])
    errors = errors_of().errors(predictor, theta)[:, 0]
    assert np.sum(residual[-errors_of().size :] ** 2) == pytest.approx(np.mean(errors**2) * plain.n_values)
    assert len(data.used) == len(residual)


def test_where_a_model_leaves_more_the_errors_of_the_torques_weigh_as_much_more() -> None:
    assert replace(weighed(), misfit=9.0).torque_weight == pytest.approx(3 * weighed().torque_weight)


def test_deviations_of_parameters_allow_for_the_spectrum_of_what_is_left_of_the_torques() -> None:
    """Torques with a slow error tell less than their number says."""
    values, tolerance = friction(), tolerance_of(with_rotors(), {})
    deviations = []
    for size in (0.0, 1.0):
        slow = size * np.sin(2 * np.pi * 0.4 * T * np.arange(len(errors_of().torque)))
        wrong = replace(errors_of(), torque=errors_of().torque + slow[:, None] * DEVIATION)
        data = replace(weighed(), torques=wrong)
        predictor, theta = predictor_of(values, tolerance)
        fitted = fit(predictor, data, theta[:, 0], 4)
        names, covariance = covariance_of(fitted, data)
        deviations.append(np.sqrt(covariance[names.index("coulomb_friction@motor_1.level")][0]))
    assert deviations[1] > 1.5 * deviations[0]


def test_torques_of_an_encoder_with_another_zero_are_those_at_the_true_positions() -> None:
    """The same torques, and positions that are read 0.1 rad too large: with that offset the errors are the old ones."""
    record = record_of_arm(imported=True)
    read = replace(record, position=record.position + np.array([0.0, 0.1]))
    of = torque_errors(read, model(), 0.0, DEVIATION)
    assert of is not None
    offset = {"encoder_offset@motor_2": {"offset": 0.1}}
    assert np.all(size_of(friction(), of) > 3 * size_of(friction()))
    np.testing.assert_allclose(size_of({**friction(), **offset}, of), size_of(friction()), rtol=1e-3)


@pytest.mark.parametrize("delay", [0.0, 2 * T])
def test_torques_behind_a_lag_are_those_of_the_lag(delay: float) -> None:
    """A lag left the torques as they are, so that a delay stood for it. The errors begin from a delay or without."""
    record, lag, fine = record_of_arm(imported=True), 0.02, 50
    time, dense = T * np.arange(record.n_samples), T / fine * np.arange(fine * record.n_samples)
    acting = np.interp(dense, time, record.torque[:, 0])
    command = acting + lag * np.gradient(acting, dense)
    smooth = np.convolve(np.pad(command, fine // 2, "edge"), np.ones(fine) / fine, "same")[fine // 2 : -fine // 2]
    torque = record.torque.copy()
    torque[:, 0] = smooth[::fine][: record.n_samples]
    of = torque_errors(replace(record, torque=torque), model(), delay, DEVIATION)
    assert of is not None
    name = "actuator_lag@motor_1"
    with_lag = size_of({**friction(), name: {"time_constant": lag}}, of)[0]
    with_delay = size_of({**friction(), "delay@motor_1": {"time": lag}}, of)[0]
    assert with_lag < 0.5 * with_delay
    assert with_lag < 0.3 * size_of(friction(), of)[0]


@pytest.mark.parametrize("delay", [0.0, 2 * T])
def test_torques_beyond_a_limit_are_those_within_it(delay: float) -> None:
    record, limit = record_of_arm(imported=True), 20.0
    beyond = np.abs(record.torque) > limit
    assert 0.05 < beyond[:, 0].mean() < 0.7
    commands = replace(record, torque=np.where(beyond, 1.5 * record.torque, record.torque))
    within = replace(record, torque=np.clip(record.torque, -limit, limit))
    of, expected = (torque_errors(one, model(), delay, DEVIATION) for one in (commands, within))
    assert of is not None
    assert expected is not None
    limited = {**friction(), "torque_saturation@motor_1": {"limit": limit}}
    assert size_of(limited, of)[0] == pytest.approx(size_of(friction(), expected)[0], rel=1e-2)
    assert size_of(limited, of)[0] < 0.9 * size_of(friction(), of)[0]
