"""Stretches of a real machine in which brakes hold an arm whose drives are off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.checked_log import checked_log
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.record.checks.braked import without_braked_rests
from flexros.record.record import Record
from tests.gap.rigid_arm import T, arm, record_of_arm

BEFORE = 400  # samples


def braked(*, torque: float = 0.0, before: int = BEFORE, imported: bool = True) -> Record:
    """Return a log that begins with an arm at rest, with a torque [Nm]."""
    record = record_of_arm(imported=imported)
    rest = np.tile(record.position[:1], (before, 1))
    rest = rest + 1e-6 * np.random.default_rng(1).normal(size=rest.shape)
    return replace(
        record,
        position=np.concatenate([rest, record.position]),
        torque=np.concatenate([np.full((before, 2), torque), record.torque]),
        valid=np.concatenate([np.ones(before, dtype=bool), record.valid]),
    )


def test_samples_of_an_arm_that_brakes_hold_do_not_count() -> None:
    record = without_braked_rests(braked(), arm())
    np.testing.assert_array_equal(np.flatnonzero(~record.valid), np.arange(BEFORE))
    assert record.warnings[-1].startswith(
        "all torques are exactly zero for 2 s, the first time at 0 s, although the weight of the arm would move it"
    )


def test_pauses_between_joined_runs_are_not_counted_again() -> None:
    """The last half of the rest was not measured."""
    rests = braked()
    valid = rests.valid.copy()
    valid[BEFORE // 2 : BEFORE] = False
    record = without_braked_rests(replace(rests, valid=valid), arm())
    assert record.warnings[-1].startswith("all torques are exactly zero for 1 s, the first time at 0 s")
    assert not record.valid[:BEFORE].any()
    nothing = np.r_[np.zeros(BEFORE, dtype=bool), rests.valid[BEFORE:]]
    assert not without_braked_rests(replace(rests, valid=nothing), arm()).warnings


def test_the_record_of_a_log_leaves_them_out(tmp_path) -> None:
    table, mapping = tmp_path / "log.csv", tmp_path / "log.yaml"
    record = braked()
    columns = np.column_stack([record.position, record.torque])
    np.savetxt(table, columns, delimiter=",", header="q1,q2,u1,u2", comments="")
    lines = [
        f"  - {{column: {name}{k}, quantity: {quantity}, joint: motor_{k}, unit: {unit}}}"
        for name, quantity, unit in (("q", "position", "rad"), ("u", "measured_torque", "Nm"))
        for k in (1, 2)
    ]
    mapping.write_text("\n".join(["name: log", "source: test", f"time: {{rate: {1 / T}}}", "columns:", *lines]))
    checked = checked_log(import_log(load_mapping(str(mapping)), [table]), arm(), name="log")
    assert not checked.valid[: BEFORE - 2].any()
    assert checked.valid[BEFORE + 2 :].all()


@pytest.mark.parametrize("case", ["torque", "hangs", "short", "falls", "simulated", "no drive"])
def test_other_rests_count(case: str) -> None:
    """A torque that is not zero, links that hang down, a moment, a fall, logs of this program, no drive at a joint."""
    record = {
        "torque": braked(torque=1e-9),
        "hangs": _hanging(),
        "short": braked(before=20),
        "falls": _falling(),
        "simulated": braked(imported=False),
        "no drive": _without_drive(),
    }[case]
    assert without_braked_rests(record, arm()) is record


def _hanging() -> Record:
    """Return a log that begins with both links straight down."""
    record = braked()
    position = record.position.copy()
    position[:BEFORE] = np.array([0.5 * np.pi, 0.0])
    return replace(record, position=position)


def _falling() -> Record:
    """Return a log that begins with a free fall from a level pose, at a quarter of the acceleration of gravity."""
    record = braked()
    position = record.position.copy()
    position[:BEFORE] = (0.125 * 9.81 / 0.3) * (T * np.arange(BEFORE)[:, None]) ** 2 * np.array([1.0, 0.0])
    return replace(record, position=position)


def _without_drive() -> Record:
    """Return a log that begins with a pendulum at rest below the first link, the zero of its encoder a little off."""
    record = _hanging()
    position = record.position.copy()
    position[:BEFORE, 1] = 0.07
    return replace(record, position=position, torque=record.torque * [1.0, 0.0])
