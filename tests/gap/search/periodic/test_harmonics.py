"""Waves in the rotor angle are found where they enter, with order, amplitude and phase."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects.kinds.ranges import Entry
from flexros.gap.search.periodic import harmonics
from flexros.gap.search.periodic.harmonics import OrderSearch, _local_stiffness, _with_mean_stiffness, angle_spectrum
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import ROBOT, SECONDS, WHOLE, record_of, search_of

ENTRIES: tuple[Entry, ...] = ("torque", "proportional torque", "gear", "encoder")


def order_search(*effects: str, length: float = SECONDS) -> OrderSearch:
    search = search_of(*effects, length=length)
    return OrderSearch(ROBOT, search.data, search.base_residual, search.null.fit.states(search.data))


def resolution(length: float = SECONDS) -> float:
    """Order whose period is the range of the rotor angle."""
    return float(2 * np.pi / np.ptp(record_of(length=length).position))


def errors_of(search: OrderSearch, entry: Entry, wave: FloatArray) -> FloatArray:
    """Weighted prediction errors of a disturbance, shape (n, M)."""
    errors = search._forward(search._source(0, entry), wave + 0j).real
    return search.data.weighted(errors[:, :, None])[:, 0].reshape(1, -1).T


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "entry", "amplitude"),
    [
        ("torque_ripple@motor_1:amplitude={},order=7,phase=0.8", "torque", 5e-3),
        ("torque_ripple@motor_1:amplitude={},order=7,phase=0.8,proportional=true", "proportional torque", 0.01),
        ("transmission_error@motor_1:amplitude={},order=7,phase=0.8", "gear", 5e-4),
        ("encoder_eccentricity@motor_1:amplitude={},order=7,phase=0.8", "encoder", 5e-4),
    ],
)
def test_a_wave_is_found_where_it_enters(effect: str, entry: Entry, amplitude: float) -> None:
    search = order_search(effect.format(amplitude))
    best = {kind: search.search(0, kind)[0] for kind in ENTRIES}
    assert max(best, key=lambda kind: best[kind].gain) == entry
    found = best[entry]
    assert found.order == pytest.approx(7.0, abs=0.3 * resolution())
    assert found.amplitude == pytest.approx(amplitude, rel=0.4)


def test_the_steps_of_an_encoder_are_no_order() -> None:
    """What is rounded errs with the order of the steps in a turn, as with a harmonic of it."""
    search = order_search()
    wave = 1e-4 * np.sin(70.0 * search._angle(0))
    search._residual = errors_of(search, "encoder", wave)
    assert search.search(0, "encoder")[0].order == pytest.approx(70.0, abs=0.3 * resolution())
    stepping = replace(search.data.record, encoder_steps=(2 * np.pi / 70.0,))
    search.data = replace(search.data, record=stepping)
    assert all(one.order < 36.0 for one in search.search(0, "encoder"))


def test_an_order_that_counts_behind_a_gear_may_be_high() -> None:
    """24 periods per turn of a rotor behind a gear of 100, on a robot whose file does not tell the ratio."""
    search = order_search()
    search._states = search._states / 400.0
    wave = 1e-4 * np.sin(2400.0 * search._angle(0) + 0.8)
    search._residual = errors_of(search, "encoder", wave)
    found = search.search(0, "encoder")[0]
    assert found.order == pytest.approx(2400.0, abs=0.3 * 400.0 * resolution())
    assert found.amplitude == pytest.approx(1e-4, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "amplitude"), [(20.0, 5e-4), (120.0, 0.02)])
def test_an_order_is_found_although_slow_motion_shows_others_nearly_as_well(order: float, amplitude: float) -> None:
    """Most of the errors come from creeping, in which few periods pass: orders far away gain 96 % of the true one."""
    search = order_search(f"torque_ripple@motor_1:amplitude={amplitude},order={order},phase=0.8")
    assert search.search(0, "torque")[0].order == pytest.approx(order, abs=0.3 * resolution())


def test_an_order_that_only_slower_motion_resolves_is_found() -> None:
    """As that of the poles of a motor on a fast arm at 500 Hz; a torque acts by its mean over a sample."""
    search = order_search()
    seconds = np.arange(len(search._states)) * ROBOT.sample_time
    angle = 8.0 * np.sin(2 * np.pi * seconds) + 5.0 * np.sin(0.74 * np.pi * seconds + 1.0)
    search._states = np.tile(angle[:, None], search._states.shape[1])
    turned = 107.0 * search._angle(0)
    step = np.gradient(turned)
    assert np.quantile(np.abs(step), 0.95) > 0.45 * 2 * np.pi
    search._residual = errors_of(search, "torque", 0.02 * np.sin(turned + 0.8) * np.sinc(step / (2 * np.pi)))
    found = search.search(0, "torque")[0]
    assert found.order == pytest.approx(107.0, abs=0.01)
    assert found.amplitude == pytest.approx(0.02, rel=1e-3)


def test_a_wave_of_the_right_order_is_fitted_with_amplitude_and_phase() -> None:
    found = order_search("torque_ripple@motor_1:amplitude=0.005,order=7,phase=0.8").fit(0, "torque", 7.0)
    assert found.amplitude == pytest.approx(0.005, rel=0.03)
    assert found.phase == pytest.approx(0.8, abs=0.05)


@pytest.mark.parametrize("order", [5.03, 6.36, 7.11])
def test_an_order_between_those_of_the_grid_gains_nearly_as_much_as_the_true_one(order: float) -> None:
    """The spectrum does not know how much of each order the errors hold: it may peak in another valley."""
    search = order_search(length=WHOLE)
    wave = 0.005 * np.sin(order * search._angle(0) + 0.8)
    search._residual = errors_of(search, "torque", wave)
    found = search.search(0, "torque")[0]
    assert found.order == pytest.approx(order, abs=0.05 * resolution(WHOLE))
    assert found.gain > 0.995 * search.fit(0, "torque", order).gain


def test_orders_stay_within_what_the_log_resolves() -> None:
    """A spectrum without peaks, or a peak at its end, has no order beyond it."""
    search = order_search()
    angle = search._angle(0)
    highest = search._highest(0, angle)
    wave = 0.005 * np.sin(0.999 * highest * angle)
    search._residual = errors_of(search, "encoder", wave)
    found = search.search(0, "encoder", most=4)
    assert all(resolution() <= one.order <= highest for one in found)
    search._highest = lambda motor, angle: 1.01 * resolution()  # type: ignore[method-assign]
    assert search.search(0, "encoder") == ()


def test_a_motor_whose_positions_do_not_count_hides_no_order_of_others() -> None:
    search = order_search("torque_ripple@motor_1:amplitude=0.005,order=7,phase=0.8")
    source = search._source(0, "torque")
    alone = list(search._disturbances(source))
    search._spectra = {key: np.column_stack([one, one]) for key, one in search._spectra.items()}
    search._residual = np.column_stack([search._residual, search._residual])
    beside = replace(search.data, spread=np.column_stack([search.data.spread, np.full(len(search._residual), np.inf)]))
    search.data = beside
    for expected, found in zip(alone, search._disturbances(source), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_a_convolution_yields_the_same_errors_as_the_filters_of_all_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    search = order_search()
    wave = np.exp(7j * search._angle(0))
    for entry in ENTRIES:
        source = search._source(0, entry)
        slowly = search._forward(source, wave)
        with monkeypatch.context() as many:
            many.setattr(harmonics, "MANY", 0)
            found = search._forward(source, wave)
        assert search._spectra
        np.testing.assert_allclose(found, slowly, atol=1e-9 * np.abs(slowly).max())


def test_waves_come_by_gain() -> None:
    gains = [one.gain for one in order_search().search(0, "torque", most=3)]
    assert gains == sorted(gains, reverse=True)


def test_without_a_wave_the_best_gains_little() -> None:
    assert order_search().search(0, "torque")[0].gain < 40.0


def test_the_spectrum_over_angles_is_the_sum_over_samples() -> None:
    rng = np.random.default_rng(0)
    angle = np.cumsum(rng.normal(size=3000)) * 0.1
    signal = rng.normal(size=3000)
    orders, score = angle_spectrum(signal, angle, 20.0)
    expected = np.abs(np.exp(1j * np.outer(orders, angle)) @ signal)
    low = orders < 10.0
    np.testing.assert_allclose(score[low], expected[low], atol=0.05 * expected.max())
    assert orders[-1] <= 20.0


def test_a_motor_that_does_not_turn_has_no_orders() -> None:
    search = order_search()
    search._states = np.zeros_like(search._states)
    assert search.search(0, "torque") == ()


def test_springs_that_stiffen_count_with_their_stiffness_along_the_motion() -> None:
    robot = load_robot("four_mass")
    n = robot.n_coordinates
    states = np.zeros((200, 2 * n))
    states[100:, robot.motor_rows[0]] = 1.0  # far beyond the knee of the first spring
    soft, stiff = (_local_stiffness(robot, 0, states[part]) for part in (slice(100), slice(100, None)))
    law = robot.joints[0].direction.spring.piecewise_linear
    np.testing.assert_allclose(soft, law.slopes[0])
    np.testing.assert_allclose(stiff, law.slopes[-1])
    mean = _with_mean_stiffness(robot, states)
    np.testing.assert_allclose(_local_stiffness(mean, 0, np.zeros((1, 2 * n))), (soft[0] + stiff[0]) / 2)
    assert _with_mean_stiffness(ROBOT, states) is ROBOT
