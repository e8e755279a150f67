"""The whole monitor: silent on its model, loud on effects, the same however messages come, honest about what it saw."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.effects import parse_effect
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.logs.time_series import JointSeries, Log
from flexros.monitor.alarms import Level
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.statement import motor_sentence, robot_sentence
from flexros.monitor.watch import WindowResult
from flexros.monitor.watch_log import watch_log

pytestmark = pytest.mark.slow

MakeLog = Callable[..., Log]
MakeMonitor = Callable[[str], GapMonitor]


def feed(monitor: GapMonitor, log: Log, chunk: int) -> list[WindowResult]:
    states, commands = log.joint_states, log.joint_commands
    assert states.position is not None
    assert commands is not None
    assert commands.effort is not None
    found = []
    for i in range(0, len(states.stamp), chunk):
        monitor.add_states(states.stamp[i : i + chunk], states.position[i : i + chunk])
        monitor.add_commands(commands.stamp[i : i + chunk], commands.effort[i : i + chunk])
        found += monitor.advance()
    return found


def changed(log: Log, keep: np.ndarray) -> Log:
    """Keep some of the states alone."""
    states = log.joint_states
    assert states.position is not None
    fewer = JointSeries(states.stamp[keep], states.names, position=states.position[keep])
    return Log(joint_states=fewer, joint_commands=log.joint_commands)


@pytest.mark.parametrize("robot", ["four_mass_linear", "four_mass", "elbow", "e12", "two_mass", "emps"])
def test_it_is_silent_on_a_robot_that_is_as_its_model(robot: str, make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    monitor = make_monitor(robot)
    feed(monitor, make_log(robot, seed=21), 1000)
    assert (monitor.alarms, monitor.warnings, monitor.runaways) == (0, 0, 0)
    reading = monitor.reading()
    assert reading.level is Level.OK
    assert robot_sentence(reading) == "no model mismatch beyond the accepted level"
    assert all(motor.gap == pytest.approx(1.0, abs=0.7) for motor in reading.motors)


@pytest.mark.parametrize(
    ("robot", "effect", "joint"),
    [
        ("four_mass_linear", "viscous_friction@motor_1:coefficient=1e-3", "motor_1"),
        ("elbow", "coulomb_friction@motor_2:level=1", "motor_2"),
        ("elbow", "backlash@motor_1:gap=2e-5", "motor_1"),
        ("e12", "payload_error@tool:relative=0.02", "tool"),
        ("emps", "coulomb_friction@motor_1:level=5", "motor_1"),
    ],
)
def test_it_alarms_and_names_the_joint(
    robot: str, effect: str, joint: str, make_log: MakeLog, make_monitor: MakeMonitor
) -> None:
    found = watch_log(make_log(robot, effect), make_monitor(robot), name="log")
    assert found.episodes
    assert found.episodes[-1].joint == joint
    assert found.reading.level is Level.ALARM
    assert f"alarm since {found.episodes[-1].since * 1e-9:.1f} s: model mismatch" in found.episodes[-1].sentence


def test_it_says_the_same_however_messages_come(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    log = make_log("elbow", "coulomb_friction@motor_2:level=1")
    whole, cut = (feed(make_monitor("elbow"), log, chunk) for chunk in (100_000, 37))
    assert len(whole) == len(cut) > 50
    for a, b in zip(whole, cut):
        assert a.stamp == b.stamp
        np.testing.assert_array_equal(
            np.concatenate([a.innovation, a.disturbance]), np.concatenate([b.innovation, b.disturbance])
        )
        np.testing.assert_array_equal(a.torque, b.torque)


def test_saturated_commands_are_no_gap(make_monitor: MakeMonitor) -> None:
    from flexros.scenario.closed_loop import closed_loop
    from flexros.scenario.experiment import Experiment
    from flexros.scenario.scenario import load_scenario

    changes = {"robot": "four_mass_linear", "diagnosis.length": 12, "seed": 5}
    experiment = Experiment.prepare(load_scenario("diagnosis").with_values(changes, "test"))
    experiment.reference.torque[:] += np.where(np.arange(experiment.n_samples) % 4000 < 60, 30.0, 0.0)[:, None]
    log = closed_loop(experiment)
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    assert np.mean(np.abs(log.joint_commands.effort) >= 20.0) > 0.001
    assert watch_log(log, make_monitor("four_mass_linear"), name="log").episodes == ()


def test_lost_states_are_bridged_without_an_alarm(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    log = make_log("elbow")
    keep = np.random.default_rng(1).uniform(size=len(log.joint_states.stamp)) > 0.05
    monitor = make_monitor("elbow")
    found = watch_log(changed(log, keep), monitor, name="log")
    assert found.episodes == ()
    assert monitor.counts.missing > 1000
    assert found.reading.seen > 0.5


def test_a_gap_in_the_stream_costs_a_new_start_and_is_told(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    log = make_log("elbow")
    keep = np.ones(len(log.joint_states.stamp), dtype=bool)
    keep[12_000:13_000] = False
    whole, monitor = make_monitor("elbow"), make_monitor("elbow")
    everything = watch_log(log, whole, name="log")
    found = watch_log(changed(log, keep), monitor, name="log")
    assert found.episodes == ()
    assert monitor.counts.lost_windows == 5
    assert monitor.settled > whole.settled
    assert found.reading.seen < everything.reading.seen


def test_a_model_with_effects_is_watched_with_them(make_log: MakeLog) -> None:
    effect = "viscous_friction@motor_2:coefficient=20"
    patched = load_model("elbow").with_effects([parse_effect(effect, "test")])
    log = make_log("elbow", effect)
    assert watch_log(log, GapMonitor(patched), name="log").episodes == ()
    assert watch_log(log, GapMonitor(load_model("elbow")), name="log").episodes[-1].joint == "motor_2"


def test_before_the_first_message_it_names_the_topics_it_waits_for(make_monitor: MakeMonitor) -> None:
    reading = make_monitor("elbow").reading()
    assert robot_sentence(reading) == "waiting for joint_states and joint_commands"
    assert reading.level is Level.OK


def test_sentences_name_size_and_unit(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    found = watch_log(make_log("elbow", "coulomb_friction@motor_2:level=3"), make_monitor("elbow"), name="log")
    text = motor_sentence(found.reading.motors[1], "Nm")
    assert text.startswith("alarm since ")
    assert " Nm rms, " in text
    assert text.endswith(" times its noise floor")
    assert "motor_2" in robot_sentence(found.reading)


def test_logs_that_cannot_be_monitored_are_rejected(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    log = make_log("elbow")
    with pytest.raises(InputError, match="^log has no torques in joint_commands, without which the observer"):
        watch_log(Log(joint_states=log.joint_states), make_monitor("elbow"), name="log")
    keep = np.zeros(len(log.joint_states.stamp), dtype=bool)
    keep[:500] = True
    with pytest.raises(InputError, match="^log: no window could be evaluated: 500 states"):
        watch_log(changed(log, keep), make_monitor("elbow"), name="log")


def test_states_without_commands_are_reported(make_log: MakeLog, make_monitor: MakeMonitor) -> None:
    """The last verdict is not repeated alone when the commands change to another clock."""
    log, monitor = make_log("elbow"), make_monitor("elbow")
    states, commands = log.joint_states, log.joint_commands
    assert states.position is not None
    assert commands is not None
    assert commands.effort is not None
    half = len(states.stamp) // 2
    offset = np.where(np.arange(len(commands.stamp)) < half, 0, 500 * 10**9)
    monitor.add_states(states.stamp, states.position)
    monitor.add_commands(commands.stamp + offset, commands.effort)
    monitor.advance()
    reading = monitor.reading()
    assert reading.stamp > 0
    assert reading.unpaired == pytest.approx((len(states.stamp) - half) * 5e-4, abs=0.2)
    sentence = robot_sentence(reading)
    assert "; monitoring suspended: no joint_commands for the last " in sentence
    assert sentence.endswith(" s of joint_states")
