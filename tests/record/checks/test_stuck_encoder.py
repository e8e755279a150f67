"""An encoder with noise in every sample cannot repeat its value."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.checks.run import check_record
from flexros.robot import load_robot

pytestmark = pytest.mark.slow


def stuck(position: np.ndarray, first: int, length: int) -> np.ndarray:
    changed = position.copy()
    changed[first : first + length, 0] = changed[first, 0]
    return changed


def test_stuck_samples_are_told_and_do_not_count(found, healthy) -> None:
    record = healthy("emps")
    (finding,) = found("emps", position=stuck(record.position, 6000, 1000))
    assert not finding.hopeless
    assert "the encoder of motor_1 repeats its value in 999 samples, the first at 6.001 s" in finding.text
    np.testing.assert_array_equal(np.flatnonzero(finding.spoilt), np.arange(6001, 7000))


def test_spoilt_samples_are_not_valid_any_more(healthy) -> None:
    from dataclasses import replace

    record = healthy("emps")
    checked = check_record(replace(record, position=stuck(record.position, 6000, 1000)), load_robot("emps"))
    assert (~checked.valid).sum() == 999
    assert any("repeats its value" in text for text in checked.warnings)


@pytest.mark.parametrize("share", [0.5])
def test_mostly_stuck_is_refused(found, healthy, share: float) -> None:
    record = healthy("emps")
    findings = found("emps", position=stuck(record.position, 3000, int(share * record.n_samples)))
    assert any(finding.hopeless and "repeats its value" in finding.text for finding in findings)


def test_encoder_that_never_changes_is_refused(found, healthy) -> None:
    record = healthy("e12")
    position = record.position.copy()
    position[:, 0] = 0.2
    findings = found("e12", position=position)
    assert findings[0].hopeless
    assert "the position of motor_1 never changes although its torque does" in findings[0].text


def test_of_several_encoders_of_a_real_machine_that_never_change_none_is_stuck(found, healthy) -> None:
    """They are told in one line, and those that are prescribed not at all."""
    record = healthy("e12")
    position = np.tile(record.position[0], (record.n_samples, 1))
    texts = [finding.text for finding in found("e12", position=position, imported=True)]
    told = "the positions of motor_1, motor_2 never change; nothing about these motors is identifiable"
    assert [text for text in texts if "never change" in text] == [told]
    moving = np.column_stack([record.position[:, 0], position[:, 1]])
    texts = [finding.text for finding in found("e12", position=moving, imported=True, prescribed=(1,))]
    assert not any("never change" in text or "does not move" in text for text in texts)


def test_coarse_encoder_may_rest(found, healthy) -> None:
    record = healthy("emps")
    texts = [finding.text for finding in found("emps", position=2e-5 * np.round(record.position / 2e-5))]
    assert not any("repeats its value" in text for text in texts)


def test_joint_that_stands_still_on_purpose_is_told_only(found, healthy) -> None:
    record = healthy("e12")
    position, reference = record.position.copy(), record.reference.copy()
    position[:, 0], reference[:, 0] = 0.2, 0.2
    findings = found("e12", position=position, reference=reference)
    assert any("never changes" in finding.text and not finding.hopeless for finding in findings)
    assert not any("never changes" in finding.text and finding.hopeless for finding in findings)


def test_equal_values_beside_a_long_hole_are_not_in_a_row(found, healthy) -> None:
    record = healthy("emps")
    position, valid = stuck(record.position, 5995, 5), record.valid.copy()
    position[6100:6105, 0] = position[5995, 0]
    valid[6000:6100] = False
    texts = [finding.text for finding in found("emps", position=position, valid=valid)]
    assert not any("repeats its value" in text for text in texts)
