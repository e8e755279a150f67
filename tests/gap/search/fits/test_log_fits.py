"""Fits to one log: how they are begun, carried on and ended, and work on several of them at a time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.fits.log_fits import LogFits, _hopeless
from tests.gap.diagnosis_logs import candidates_of, predictor_of, search_of

pytestmark = pytest.mark.slow

FRICTION = "coulomb_friction@motor_1:level=0.05"


def _of(data: FitData, *, imported: bool) -> FitData:
    return replace(data, record=replace(data.record, imported=imported))


def test_a_fit_that_stays_far_out_of_tolerance_is_tried_from_the_nominal_numbers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = search_of(FRICTION, tolerance=Tolerance(("body_2.rz.stiffness",), (0.03,)))
    friction = candidates_of()["coulomb_friction@motor_1"]
    far = np.array([friction.free[0].encode(0.05), 4.5])
    stuck = CandidateFit(search.null.predictor((friction,)), far, search.null.fit.chi2)
    monkeypatch.setattr(Search, "_continued", lambda *_, **__: stuck)
    found = search.completed(stuck)
    assert found.chi2 / search.data.n_values == pytest.approx(1.0, abs=0.05)
    assert abs(found.deviations[0]) < 1.0


@pytest.mark.parametrize(("tolerance", "expected"), [(None, 20), (Tolerance(("body_2.rz.stiffness",), (0.03,)), 60)])
def test_fits_beside_tolerated_numbers_are_carried_on_along_their_valleys(
    tolerance: Tolerance | None, expected: int
) -> None:
    assert search_of(FRICTION, tolerance=tolerance)._most_iterations == expected


def test_a_second_initial_value_without_hope_to_reach_the_first_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    rivals: list[float] = []
    quick = Search._quick

    def recorded(search: Search, predictor: Predictor, start: FloatArray, rival: float = np.inf) -> CandidateFit:
        rivals.append(rival)
        return quick(search, predictor, start, rival)

    monkeypatch.setattr(Search, "_quick", recorded)
    search = search_of(FRICTION)
    search._from_grid(predictor_of(candidates_of()["delay@all"]), np.array([[-9.0, -6.0]]))
    assert rivals[0] == np.inf
    assert np.isfinite(rivals[-1])


def test_single_effects_without_hope_to_reach_the_most_promising_one_are_given_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rivals: dict[str, float] = {}
    quick = Search._quick

    def recorded(search: Search, predictor: Predictor, start: FloatArray, rival: float = np.inf) -> CandidateFit:
        rivals.setdefault(predictor.hypothesis[0].name, rival)
        return quick(search, predictor, start, rival)

    monkeypatch.setattr(Search, "_quick", recorded)
    search = search_of(FRICTION)
    every = candidates_of()
    names = ("coulomb_friction@motor_1", "delay@all", "stiffness_error@body_2.rz")
    found = search.singles(search.directions([every[name] for name in names]))
    first = next(iter(rivals))
    assert first == found[0].hypothesis[0].name == names[0]
    assert rivals.pop(first) == np.inf
    assert list(rivals.values()) == pytest.approx([found[0].chi2] * 2, rel=0.01)


@pytest.mark.parametrize(("imported", "expected"), [(False, 5.0), (True, np.inf)])
def test_orders_beside_that_of_a_fit_without_hope_to_do_better_are_given_up(
    imported: bool, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(FRICTION)
    search = replace(search, null=replace(search.null, data=_of(search.data, imported=imported)))
    rivals = []

    def recorded(_: Search, predictor: Predictor, start: FloatArray, rival: float = np.inf) -> CandidateFit:
        rivals.append(rival)
        return CandidateFit(predictor, start, 9.0)

    monkeypatch.setattr(Search, "_quick", recorded)
    monkeypatch.setattr("flexros.gap.search.fits.log_fits.neighbouring_orders", lambda *_: np.zeros((1, 3)))
    fit = CandidateFit(predictor_of(candidates_of()["torque_bias@motor_1"]), np.zeros(1), 5.0)
    assert search._near_best_order(fit) is fit
    assert rivals == [expected] * 2


@pytest.mark.parametrize("imported", [False, True])
def test_a_fit_is_compared_near_its_end_in_a_simulated_log_and_at_it_in_a_measured_one(
    imported: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of(FRICTION)
    search = replace(search, null=replace(search.null, data=_of(search.data, imported=imported)))
    completed: list[CandidateFit] = []
    monkeypatch.setattr(Search, "completed", lambda _, fit: completed.append(fit) or fit)
    friction = candidates_of()["coulomb_friction@motor_1"]
    fit = CandidateFit(predictor_of(friction), np.array([friction.free[0].encode(0.04)]), np.inf)
    found = search.to_compare(fit)
    assert completed == ([fit] if imported else [])
    assert imported or found.chi2 / search.data.n_values == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("imported", "expected"), [(True, 1.0), (False, 1.5)], ids=["measured", "simulated"])
def test_a_fit_to_a_measured_log_that_was_ended_before_is_carried_to_its_end(imported: bool, expected: float) -> None:
    """That of a measured leg left 120,354 where 118,655 was possible, and its sizes were those of the way."""
    search = search_of(FRICTION)
    search = replace(search, null=replace(search.null, data=_of(search.data, imported=imported)))
    friction = candidates_of()["coulomb_friction@motor_1"]
    compared = CandidateFit(
        predictor_of(friction), np.array([friction.free[0].encode(0.04)]), 1.5 * search.data.n_values
    )
    ended = search.at_its_end(compared)
    assert ended.chi2 / search.data.n_values == pytest.approx(expected, abs=0.05)
    assert search.at_its_end(ended) is ended


def test_when_the_time_is_over_only_what_is_needed_is_done() -> None:
    search = replace(search_of(), deadline=Deadline(interrupted=lambda: True))
    assert search.parallel("numbers", lambda number: 2 * number, [1, 2, 3], needed=1) == [2]
    assert search.directions(search.candidates()) == []
    assert search.harmonics(search.null.fit) == ()
    assert search.singles([]) == []
    assert search.misfit([]) >= 1.0


def test_work_that_breaks_off_ends_the_fits_that_still_run() -> None:
    search = replace(search_of(), deadline=Deadline())

    def breaks(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search.parallel("numbers", breaks, [1])
    assert search.deadline.of_fit(finishing=True)()


@pytest.mark.parametrize(("excess", "further", "rival", "expected"), [
    (100.0, 2, 1.0, False),  # a tenth of what was left before
    (900.0, 2, 1.0, True),
    (900.0, 2, np.inf, False),
    (900.0, 0, 1000.0, False),
    (-5.0, 2, -20.0, False),
])  # fmt: skip
def test_a_joint_fit_ends_that_does_not_fall_fast_enough(
    excess: float, further: int, rival: float, expected: bool
) -> None:
    assert _hopeless(excess, 1000.0, further, rival) is expected


@pytest.mark.parametrize(("fall", "calls"), [(1.0, 2), (100.0, 5)], ids=["less", "more"])
def test_a_fit_below_the_noise_goes_on_while_it_gains_more_than_a_parameter_costs(
    fall: float, calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of("coulomb_friction@motor_1:level=0.3")
    found: list[CandidateFit] = []

    def falling(self: LogFits, predictor: Predictor, theta: FloatArray, **_: Any) -> CandidateFit:
        found.append(CandidateFit(predictor, theta, 0.9 * self.data.n_values - fall * len(found), iterations=5))
        return found[-1]

    monkeypatch.setattr(LogFits, "_fit", falling)
    search.reshaped(search.null.fit, ())
    assert len(found) == calls
