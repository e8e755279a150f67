"""Logs that lost commands: what they spoil does not count, and is no gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.arrays import BoolArray
from flexros.errors import InputError
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.lost_commands import check_enough_left
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from tests.gap.diagnosis_logs import MODEL, WHOLE, data_of, predictor_of, record_of


def held_over(record: Record, late: BoolArray, *, known: bool = True) -> Record:
    """Put the command before in place of those that are late."""
    last = np.maximum.accumulate(np.where(late, 0, np.arange(record.n_samples)))
    return replace(record, torque=record.torque[last], late=late, valid=record.valid & (known | ~late))


def data(record: Record) -> FitData:
    return fit_data(record, MODEL, DiagnosisSettings())


def level(found: FitData) -> float:
    residual = found.residuals(predictor_of(), np.zeros((0, 1)))[:, 0]
    return float(residual @ residual) / found.n_values


def burst(record: Record, length: int) -> BoolArray:
    """Commands that are missing in the middle of the fastest motion."""
    middle = int(np.argmax(np.abs(np.gradient(record.torque[: record.n_samples // 2, 0]))))
    return np.abs(np.arange(record.n_samples) - middle) < length / 2


def test_a_log_with_all_its_commands_counts_as_before() -> None:
    record = record_of(length=WHOLE)
    none = np.zeros(record.n_samples, dtype=bool)
    np.testing.assert_array_equal(data(replace(record, late=none)).spread, data_of(length=WHOLE).spread)


def test_what_a_hole_spoils_does_not_count() -> None:
    record = record_of(length=WHOLE)
    late = burst(record, 100)
    found = data(held_over(record, late, known=False))
    assert level(found) == pytest.approx(1.0, abs=5 * np.sqrt(2 / found.n_values))
    settled = np.flatnonzero(late)[-1] + found.gain.settling + 2  # the delay is below one sample
    assert not found.counted[np.flatnonzero(late)].any()
    assert found.counted[settled:].all()
    not_led = replace(found, record=replace(found.record, bridged=None), spread=data_of(length=WHOLE).spread)
    assert level(not_led) > 10


def test_a_short_hole_is_noticed_by_its_prediction() -> None:
    record = record_of(length=WHOLE)
    late = burst(record, 3)
    found = data(held_over(record, late))
    assert not np.array_equal(found.record.torque[late], held_over(record, late).torque[late])
    assert not found.counted[np.flatnonzero(late)[-1] :][:400].all()
    assert level(found) == pytest.approx(1.0, abs=5 * np.sqrt(2 / found.n_values))


def test_one_lost_command_costs_what_it_may_have_changed() -> None:
    record = record_of(length=WHOLE)
    late = burst(record, 1)
    found = data(held_over(record, late, known=False))
    usual, first = data_of(length=WHOLE), int(np.flatnonzero(late)[0])
    lost = usual.counted.sum() - found.counted.sum()
    assert 1 < lost < 0.1 * found.gain.settling
    wider = np.any(found.spread > usual.spread, axis=1)
    assert wider[first : first + found.gain.settling].any()
    assert not wider[first + found.gain.settling :].any()
    assert not wider[: first - 1].any()


def test_commands_that_were_held_in_truth_count() -> None:
    """A controller that was late: nothing is lost."""
    record = record_of(length=WHOLE)
    found = data(replace(record, late=burst(record, 3)))
    np.testing.assert_array_equal(found.spread, data_of(length=WHOLE).spread)


def test_a_log_that_lost_commands_everywhere_is_refused() -> None:
    record = record_of(length=WHOLE)
    late = np.arange(record.n_samples) % 97 == 50
    with pytest.raises(InputError, match=r"commands were lost when it was recorded, .* \d+ of \d+ samples are left"):
        data(held_over(record, late))


def test_a_measured_torque_is_lost_with_its_sample() -> None:
    """Neither motion nor torque is known for 2 s; the prediction is led through it and settles again."""
    record = replace(record_of(length=WHOLE), measured_torque=True)
    late = burst(record, round(2.0 / record.sample_time))
    last = np.maximum.accumulate(np.where(late, 0, np.arange(record.n_samples)))
    found = data(replace(record, position=record.position[last], torque=record.torque[last], valid=~late))
    whole = data(record)
    assert level(found) == pytest.approx(level(whole), rel=5 * np.sqrt(2 / found.n_values))
    assert not found.counted[late].any()
    assert found.counted.sum() > 0.9 * whole.counted.sum() - late.sum()


def test_the_prediction_goes_on_through_a_hole_of_a_few_samples() -> None:
    """What the torques there may have been counts by its size, and no longer than that: not until all has settled."""
    record = replace(record_of(length=WHOLE), measured_torque=True)
    missing = burst(record, 12)
    found, whole = data(replace(record, valid=~missing)), data(record)
    lost = whole.counted.sum() - found.counted.sum()
    assert missing.sum() <= lost < 0.5 * found.gain.settling
    assert level(found) == pytest.approx(level(whole), rel=5 * np.sqrt(2 / found.n_values))


def test_enough_samples_are_enough_however_small_their_share_is() -> None:
    record = record_of(length=WHOLE)
    usual = np.ones((record.n_samples, 1))
    left = np.where(np.arange(record.n_samples) < 1000, 1.0, np.inf)[:, None]
    settings = DiagnosisSettings().residuals
    assert settings.enough_left == 1000 < settings.least_left * record.n_samples
    check_enough_left(record, usual, left, settings)
    left[0] = np.inf
    with pytest.raises(InputError, match="999 of"):
        check_enough_left(record, usual, left, settings)


def test_what_is_predicted_across_a_jump_of_the_clock_does_not_count_until_that_has_decayed() -> None:
    record = record_of(length=WHOLE)
    at = int(np.argmax(np.abs(np.gradient(record.position[1000:-4000, 0])))) + 1000
    jumps = np.zeros(record.n_samples)
    jumps[at] = 1.0
    found = data(replace(record, jumps=jumps))
    assert found.counted[:at].all()
    assert not found.counted[at]
    assert found.counted[at + found.gain.settling :].all()
    slight = data(replace(record, jumps=1e-9 * jumps))
    np.testing.assert_array_equal(slight.spread, data_of(length=WHOLE).spread)
