"""Torques and motions of different instants."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.torque_balance import Delay
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.checks.time_offset import TimeOffset
from flexros.record.record import Record
from flexros.robot import load_robot


def late(record: Record, samples: int) -> Record:
    """Stamp the torques later by some samples."""
    n = record.n_samples
    return replace(
        record.part(samples, n) if samples > 0 else record.part(0, n + samples),
        torque=record.torque[: n - samples] if samples > 0 else record.torque[-samples:],
    )


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "samples"), [("emps", 1), ("e12", 2), ("e12", 20)])
def test_torques_stamped_too_late_are_refused(found, healthy, robot: str, samples: int) -> None:
    record = healthy(robot)
    findings = found(robot, late(record, samples))
    assert findings[0].hopeless
    amount = 1e3 * samples * record.sample_time
    assert f"the torques are stamped too late: the motions precede them by {amount:.2g} ms" in findings[0].text
    assert f"give 'time_offset: -{1e-3 * amount:.2g}' at the torque columns" in findings[0].text


def test_half_a_sample_is_told_only(found, healthy) -> None:
    record = healthy("e12")
    torque = record.torque.copy()
    torque[1:] = (record.torque[1:] + record.torque[:-1]) / 2
    (finding,) = found("e12", torque=torque)
    assert not finding.hopeless
    assert "precede them by 0.2" in finding.text


@pytest.mark.parametrize("time", [-0.03, 0.02])
def test_an_offset_at_which_the_motion_explains_less_of_the_torques_is_none(healthy, time: float) -> None:
    """Phases of slow bands, which dry friction of a large gear turns, had shown 34 ms where there are none."""
    checked = CheckedRecord(healthy("elbow"), load_robot("elbow"))
    checked.__dict__["delay"] = Delay(time, 1e-3, 0.1)
    assert not TimeOffset().look(checked)


@pytest.mark.parametrize(("samples", "told"), [(0, False), (-40, True)])
def test_torque_that_rises_before_a_motor_breaks_free_is_no_delay(healthy, samples: int, told: bool) -> None:
    """From point to point friction sticks: spectra take its ramp for 20 ms, and motors that slide do not."""
    robot, record = load_robot("elbow"), healthy("elbow")
    random, T = np.random.default_rng(0), record.sample_time
    second, after = np.divmod(np.arange(record.n_samples) * T, 1.0)
    moved, rested = np.clip(after / 0.6, 0, 1), np.clip((after - 0.6) / 0.4, 0, 1)  # moves 0.6 s, rests 0.4 s
    way = np.cumsum(random.uniform(0.2, 0.4, (20, 2)) * (-1.0) ** np.arange(20)[:, None], axis=0)
    here, there, next_one = (way[second.astype(int) + k] for k in range(3))
    position = here + (there - here) * (moved**3 * (10 - 15 * moved + 6 * moved**2))[:, None]
    need = rigid_inverse_dynamics(robot, position, T, 20.0)
    now, soon = np.sign(there - here), np.sign(next_one - there)
    torque = need + 3 * need.std(axis=0) * (now + (soon - now) * (rested**2)[:, None])
    torque += 0.01 * need.std(axis=0) * random.normal(size=torque.shape)
    position += 1e-6 * random.normal(size=position.shape)
    checked = CheckedRecord(late(replace(record, position=position, torque=torque), samples), robot)
    checked.__dict__["delay"] = Delay(0.02, 1e-3, 0.1)
    assert bool(TimeOffset().look(checked)) is told


@pytest.mark.slow
def test_delay_of_the_robot_file_may_be_missing(found, healthy) -> None:
    assert found("four_mass_linear", late(healthy("four_mass_linear"), 1)) == ()


def test_delay_that_an_effect_explains_is_none(found, healthy) -> None:
    assert found("e12", late(healthy("e12"), -6)) == ()


def test_very_long_delay_is_told(found, healthy) -> None:
    (finding,) = found("e12", late(healthy("e12"), -40))
    assert not finding.hopeless
    assert "the torques act 20 ms later than they are stamped" in finding.text


@pytest.mark.slow
def test_delay_is_found_within_a_tenth_of_a_sample(healthy) -> None:

    for samples in (-4, 0, 3):
        record = healthy("elbow") if samples == 0 else late(healthy("elbow"), samples)
        found = CheckedRecord(record, load_robot("elbow")).delay
        assert found.time == pytest.approx(-samples * record.sample_time, abs=5e-5)
        assert np.isfinite(found.deviation)


@pytest.mark.parametrize(("share", "late"), [(0.97, True), (0.2, False)])
def test_torques_that_agree_with_the_motion_at_no_time_are_not_late(share: float, late: bool) -> None:
    """Commands that got lost leave torques of which only slow parts fit, one time a little better than others."""
    from flexros.record.balance.torque_balance import TorqueBalance

    random = np.random.default_rng(0)
    frequency = np.linspace(2.0, 60.0, 400)
    needed, other = ((random.normal(size=(2, 400)) * [[1], [1j]]).sum(axis=0)[:, None] for _ in range(2))
    alike = np.where(frequency < 8.0, 0.97, share)[:, None]
    given = alike * needed * np.exp(2j * np.pi * 0.02 * frequency)[:, None] + np.sqrt(1 - alike**2) * other
    band, still = np.floor(2 * np.log2(frequency)).astype(int), np.zeros((400, 1, 2), dtype=complex)
    found = TorqueBalance(frequency, band, given, needed, still, np.ones((400, 1), dtype=bool)).delay()
    assert (abs(found.time) > 5 * found.deviation) == late
    assert found.time == pytest.approx(0.02, abs=1e-3) or not late


def test_a_resonance_that_the_model_lacks_is_no_offset() -> None:
    """Above a resonance torques turn by 2 rad: 34 ms would undo that at 11 Hz, and turn the clear phases at 1 to 3 Hz.

    The shares of coherent torque and the phases are those of a drive on a base that swings at 18 Hz.
    """
    from flexros.record.balance.torque_balance import TorqueBalance

    random = np.random.default_rng(0)
    bands = [(1.4, 4, 0.999, 0.0), (2.0, 6, 0.99, -0.01), (2.8, 8, 0.99, -0.08), (4.0, 10, 0.88, 0.32)]
    bands += [(5.6, 16, 0.35, 1.5), (8.0, 22, 0.9, -2.0), (11.2, 15, 0.97, -2.06)]
    frequency, share, phase = np.concatenate(
        [
            np.stack([middle * np.linspace(0.9, 1.1, n), np.full(n, coherent), np.full(n, turned)], axis=1)
            for middle, n, coherent, turned in bands
        ]
    ).T
    needed, other = ((random.normal(size=(2, len(frequency))) * [[1], [1j]]).sum(axis=0) for _ in range(2))
    given = (share * needed * np.exp(1j * phase) + np.sqrt(1 - share**2) * other)[:, None]
    band, still = np.repeat(np.arange(len(bands)), [n for _, n, *_ in bands]), np.zeros((len(frequency), 1, 2))
    clear = np.ones((len(frequency), 1), dtype=bool)
    found = TorqueBalance(frequency, band, given, needed[:, None], still.astype(complex), clear).delay()
    assert abs(found.time) < 5 * found.deviation or abs(found.time) < 0.01


def test_wrong_damping_in_one_band_of_slow_motion_is_no_offset() -> None:
    """The phase of one band tells a delay of 5 ms from wrong damping as little as 2.5 s of motion at 1 Hz do."""
    from flexros.record.balance.torque_balance import TorqueBalance

    frequency = np.linspace(0.9, 1.1, 40)
    needed = np.random.default_rng(1).normal(size=(40, 1)) + 0j
    given = needed * np.exp(-2j * np.pi * 0.005 * frequency)[:, None]
    band, still = np.zeros(40, dtype=int), np.zeros((40, 1, 2), dtype=complex)
    assert not np.isfinite(
        TorqueBalance(frequency, band, given, needed, still, np.ones((40, 1), dtype=bool)).delay().deviation
    )


@pytest.mark.slow
def test_a_lead_of_torques_that_the_model_hardly_explains_is_told_only(found, healthy, monkeypatch) -> None:
    from flexros.record.checks import time_offset

    monkeypatch.setattr(time_offset, "_agreement", lambda checked, delay: 0.6)
    findings = found("emps", late(healthy("emps"), 1))
    assert any("stamped too late" in finding.text and not finding.hopeless for finding in findings)


@pytest.mark.slow
def test_measured_torque_may_be_noted_after_it_was_held(found, healthy) -> None:
    """Then it is half a sample late anyway; a whole sample from a command of our own recorder is refused.

    Measured currents of a drive that low-passes them are later still.
    """
    record = late(healthy("emps"), 1)
    assert found("emps", record)[0].hopeless
    measured = {"measured_torque": True, "imported": True, "torque_shift": 0.0}
    assert not found("emps", record, **measured)[0].hopeless
    (filtered,) = found("emps", late(healthy("emps"), 2), **measured)
    assert not filtered.hopeless
    assert "low-passes the currents" in filtered.text
    assert found("emps", late(healthy("emps"), 12), **measured)[0].hopeless


@pytest.mark.slow
def test_command_of_another_recorder_may_be_noted_after_it_was_held(found, healthy) -> None:
    assert not found("emps", late(healthy("emps"), 1), imported=True)[0].hopeless
    assert found("emps", late(healthy("emps"), 2), imported=True)[0].hopeless


@pytest.mark.parametrize(("samples", "told"), [(2, True), (-2, False)])
def test_a_lead_of_whole_samples_that_effects_blur_is_told(found, healthy, monkeypatch, samples: int, told) -> None:
    """Four standard deviations are no proof, but no robot moves before its torque."""
    record = late(healthy("e12"), samples)
    delay = Delay(-samples * record.sample_time, abs(samples) * record.sample_time / 4.0, 0.0)
    monkeypatch.setattr(CheckedRecord, "delay", property(lambda self: delay))
    findings = [one for one in found("e12", record) if "seem to precede the torques by 1 ms" in one.text]
    assert len(findings) == told
    assert not any(one.hopeless for one in findings)
