"""What a diagnosis takes for granted of a log."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import flexros.gap
from flexros.record.premises import MEASURED, SIMULATED
from flexros.record.record import Record

OF_THE_RECORDER = {
    "candidate_fits.py",
    "checked_log.py",
    "doubts.py",
    "encoder_noise.py",
    "limits.py",
    "warnings.py",
}
"""Files that ask where a log comes from for what its recorder does: stamps, units, noise, effects of machines."""


def test_a_log_of_a_real_machine_has_a_floor_of_tolerance_and_causes_beyond_the_library() -> None:
    log = Record("log", 1e-3, np.zeros((9, 1)), np.zeros((9, 1)), np.ones(9, dtype=bool))
    assert log.premises is SIMULATED
    assert replace(log, imported=True).premises is MEASURED


def test_rules_of_the_diagnosis_ask_for_premises_and_not_where_a_log_comes_from() -> None:
    files = Path(flexros.gap.__file__).parent.rglob("*.py")
    assert {file.name for file in files if ".imported" in file.read_text(encoding="utf-8")} == OF_THE_RECORDER
