"""How many samples of a log are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.residuals.fit_samples import LENGTH, PIECES, at_rate_of_fits, part_of_fits, pieces_of_rest
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot import load_robot
from tests.gap.rigid_arm import arm

T = 1e-3
N = 100_000
SETTINGS = DiagnosisSettings()


def imported() -> Record:
    time = T * np.arange(N)
    position = np.stack([np.sin(4 * time), np.cos(5 * time)], axis=-1)
    valid = np.ones(N, dtype=bool)
    return Record(name="log", sample_time=T, position=position, torque=0 * position, valid=valid, imported=True)


def test_a_long_log_of_a_rigid_arm_has_a_lower_rate() -> None:
    record = at_rate_of_fits(imported(), arm(), SETTINGS)
    assert 1 / record.sample_time >= SETTINGS.rigid_arm.lowest_rate
    assert record.sample_time == pytest.approx(5 * T)
    assert "suffices for an arm without springs" in record.warnings[-1]


@pytest.mark.parametrize("other", ["ours", "positions are commanded", "springs"])
def test_other_logs_keep_their_rate(other: str) -> None:
    record, robot = imported(), arm()
    if other == "ours":
        record = replace(record, imported=False)
    elif other == "springs":
        robot = load_robot("elbow")
    else:
        record = replace(record, command=record.position)
    assert at_rate_of_fits(record, robot, SETTINGS) is record


def test_a_part_of_a_very_long_log_is_taken_the_shorter_for_a_rigid_arm() -> None:
    assert part_of_fits(imported(), arm(), SETTINGS).n_samples == SETTINGS.rigid_arm.most_values // 2
    assert part_of_fits(imported(), load_robot("elbow"), SETTINGS).n_samples == N


@pytest.mark.parametrize(("limit", "values"), [(None, 2 * N), (1e3, 2 * N), (20.0, 100_000), (1e-3, 50_000)])
def test_of_a_long_log_as_much_is_taken_as_there_is_time_for(limit: float | None, values: int) -> None:
    settings = DiagnosisSettings(time_limit=limit)
    part = part_of_fits(imported(), load_robot("elbow"), settings)
    assert part.position.size == values
    assert [text for text in part.warnings if "there is time for" in text] == list(part.warnings)
    assert bool(part.warnings) == (values < 2 * N)


def test_pieces_are_spread_over_what_is_not_used() -> None:
    nothing = np.zeros((1000, 1))
    whole = Record("log", 0.01, nothing, nothing, np.ones(1000, dtype=bool))
    used = whole.part(400, 800)
    pieces = pieces_of_rest(whole, used)
    assert [piece.begin for piece in pieces] == pytest.approx([0.0, 2.8, 9.6])
    assert (len(pieces), pieces[0].n_samples) == (PIECES, LENGTH * used.n_samples)
    assert pieces_of_rest(used, used) == ()
