"""Runs with all nodes in one process: equal to the direct simulation, sample for sample."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from flexros.errors import InputError
from flexros.logs.messages.diagnostic_array import DiagnosticArrayCodec
from flexros.logs.reader import read_log
from flexros.logs.stamps import stamp_ns, stamp_of
from flexros.logs.time_series import Log
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.plant import node as plant_node
from flexros_nodes.shell import spinning
from flexros_nodes.shell.reference_stream import ReferenceStream

pytestmark = pytest.mark.usefixtures("ros_domain")

Differences = Callable[[Log, Log], list[str]]


def direct(name: str) -> Log:
    return closed_loop(Experiment.prepare(load_scenario(name)))


@pytest.mark.parametrize("scenario", ["circle_dae", "circle_stable_inversion", "two_mass_step"])
def test_log_equals_the_direct_simulation(scenario: str, tmp_path: Path, log_differences: Differences) -> None:
    summary = run_scenario(scenario, tmp_path / "log")
    assert (summary.exit_code, summary.message, summary.missing) == (0, "", 0)
    log = read_log(tmp_path / "log")
    assert log_differences(direct(scenario), log) == []
    assert log.warnings == ()
    assert summary.samples == len(log.joint_states.stamp)


def test_hidden_effects_and_a_patch_go_over_topics_too(tmp_path: Path, log_differences: Differences) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: e12\neffects: [{effect: coulomb_friction, location: motor_1, parameters: {level: 100}}]\n")
    effects = ["coulomb_friction@motor_1:level=100", "backlash@motor_2:gap=0.0003", "delay@motor_1:time=0.0013"]
    scenario = load_scenario("circle_dae2").with_values({"plant.effects": effects, "feedforward_model": str(patch)})
    assert run_scenario(scenario, tmp_path / "log").exit_code == 0
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_lost_messages_are_counted_and_change_nothing(tmp_path: Path, log_differences: Differences) -> None:
    loss = {"drop_fraction": 0.01}
    summary = run_scenario("circle_dae", tmp_path / "log", parameters={"plant": loss, "controller": loss})
    assert summary.exit_code == 0
    assert summary.dropped > 0
    assert summary.resends > 0
    assert log_differences(direct("circle_dae"), read_log(tmp_path / "log")) == []


def test_lost_reference_chunks_are_sent_again(tmp_path: Path, log_differences: Differences) -> None:
    parameters = {"controller": {"drop_fraction": 0.2}, "feedforward": {"chunk_duration": 0.02, "lead": 0.04}}
    scenario = load_scenario("circle_dae").with_values({"duration": 0.1})
    summary = run_scenario(scenario, tmp_path / "log", parameters=parameters)
    assert summary.exit_code == 0
    assert summary.reports["feedforward"].figures["chunks_resent"] > 0
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_lost_reference_chunks_are_sent_again_before_they_are_needed_in_real_time(tmp_path: Path) -> None:
    # nothing waits in real time: the plant holds its last command, so lost samples would be skipped
    parameters = {
        "controller": {"drop_fraction": 0.2},
        "feedforward": {"chunk_duration": 0.02, "lead": 0.4},
        "plant": {"real_time_patience": 10.0},
    }
    scenario = load_scenario("circle_dae").with_values({"duration": 1.0})
    waits = []
    for attempt in range(3):  # once a busy machine may stop the nodes for longer than the lead; not sent again, always
        summary = run_scenario(scenario, tmp_path / f"log_{attempt}", real_time=True, parameters=parameters)
        assert summary.exit_code == 0, summary.message
        assert summary.reports["feedforward"].figures["chunks_resent"] > 0
        waits.append(summary.reports["controller"].figures["waits_for_reference"] / summary.samples)
        if waits[-1] < 0.02:
            break
    assert min(waits) < 0.02, "a fifth if not"


def test_single_threaded_executor_gives_the_same_samples(
    tmp_path: Path, log_differences: Differences, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spinning, "EventsExecutor", None)
    scenario = load_scenario("circle_dae").with_values({"duration": 0.2})
    summary = run_scenario(scenario, tmp_path / "log")
    assert summary.exit_code == 0
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_tool_reference_is_complete_though_the_last_clock_messages_were_lost(
    tmp_path: Path, log_differences: Differences, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = load_scenario("circle_dae").with_values({"duration": 0.2})
    received = ReferenceStream._on_clock
    seen: set[int] = set()

    def lossy(stream: ReferenceStream, message: bytes) -> None:
        stamp = stamp_of(message)
        if stamp in seen or stamp < stamp_ns(200, 5e-4):
            received(stream, message)
        seen.add(stamp)

    monkeypatch.setattr(ReferenceStream, "_on_clock", lossy)
    summary = run_scenario(scenario, tmp_path / "log")
    assert summary.exit_code == 0
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_run_without_a_log_records_nothing() -> None:
    summary = run_scenario("circle_dae", None)
    assert (summary.exit_code, summary.log_folder) == (0, None)
    assert set(summary.reports) == {"feedforward", "controller", "plant"}


def test_diagnostics_and_provenance_are_in_the_log(tmp_path: Path) -> None:
    run_scenario("circle_dae", tmp_path / "log")
    log = read_log(tmp_path / "log")
    assert log.other_topics["/diagnostics"] >= 1
    assert log.provenance["scenario"]["name"] == "circle_dae"
    assert log.provenance["recorded"]["joint_states.messages"] == len(log.joint_states.stamp)


def test_recorder_keeps_the_markers_of_the_arm_where_asked(tmp_path: Path) -> None:
    scenario = load_scenario("circle_dae").with_values({"duration": 1.0})
    run_scenario(scenario, tmp_path / "log", real_time=True, parameters={"recorder": {"markers": True}})
    with (tmp_path / "log" / "log_0.mcap").open("rb") as file:
        found = [
            (entry.publish_time, decoded.markers[0].header.stamp, [marker.ns for marker in decoded.markers])
            for _, _, entry, decoded in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(
                topics=["/arm_markers"]
            )
        ]
    assert len(found) >= 3
    for published, stamp, names in found:
        assert names == ["true", "magnified", "stiff"]
        # the newest stamp the recorder knows: it may be late, but it is of the run as the marker is
        assert 1.0 <= published * 1e-9 <= 2.01
        assert 1.0 <= stamp.sec + stamp.nanosec * 1e-9 <= 2.01


def test_plant_warns_of_a_motor_at_its_torque_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plant_node, "period", lambda _: 0.05)  # of diagnostics: a run in lock-step takes a second
    scenario = load_scenario("regulator_four_mass").with_values({"duration": 2.0, "controller.kp": 1e4})
    run_scenario(scenario, tmp_path / "log")
    with (tmp_path / "log" / "log_0.mcap").open("rb") as file:
        messages = [entry.data for _, _, entry in make_reader(file).iter_messages(topics=["/diagnostics"])]
    said = [status for data in messages for status in DiagnosticArrayCodec().read(data) if status.name == "/plant"]
    efforts = read_log(tmp_path / "log").joint_commands.effort
    limit = load_robot("four_mass").torque_limits
    assert said[-1].numbers()["motor_1.samples_at_torque_limit"] == np.sum(np.abs(efforts[:-1]) >= limit) > 0
    assert any(status.level == 1 and "motor_1 at its torque limit in" in status.message for status in said)


def test_real_time_run_keeps_statistics_and_never_waits(tmp_path: Path) -> None:
    scenario = load_scenario("circle_dae").with_values({"duration": 0.2})
    summary = run_scenario(scenario, tmp_path / "log", real_time=True)
    assert summary.exit_code == 0
    assert summary.timing["cycles"] == summary.samples - 1 or summary.timing["cycles"] == summary.samples
    assert summary.wall_time > 0.15
    assert 0.0 <= summary.timing["bare_late_percent"] <= 100.0
    assert summary.resends == 0


def test_runs_in_one_process_leave_no_sockets_behind() -> None:
    def sockets() -> int:
        links = [path.readlink() for path in Path("/proc/self/fd").iterdir() if path.is_symlink()]
        return sum(str(link).startswith("socket:") for link in links)

    run_scenario("circle_dae", None)
    before = sockets()
    gc.disable()  # nothing is left to it
    try:
        run_scenario("circle_dae", None)
        assert sockets() == before
    finally:
        gc.enable()


def test_summary_states_the_domain(ros_domain: int) -> None:
    assert run_scenario("circle_dae", None).domain_id == ros_domain


def test_log_time_of_a_real_time_run_is_the_time_of_arrival(tmp_path: Path) -> None:
    scenario = load_scenario("circle_dae").with_values({"duration": 0.2})
    run_scenario(scenario, tmp_path / "log", real_time=True)
    with (tmp_path / "log" / "log_0.mcap").open("rb") as file:
        messages = list(make_reader(file).iter_messages("/joint_states"))
    log_time = np.array([message.log_time for _, _, message in messages])
    stamp = np.array([message.publish_time for _, _, message in messages])
    assert log_time[0] - stamp[0] < 1_000_000
    assert (log_time != stamp).sum() > 0.9 * len(stamp)
    assert log_time[-1] - log_time[0] > 0.9 * (stamp[-1] - stamp[0])
    provenance = read_log(tmp_path / "log").provenance
    assert (provenance["transport"], provenance["real_time"]) == ("ros", True)


def test_lock_step_has_the_stamp_as_log_time(tmp_path: Path) -> None:
    run_scenario("circle_dae", tmp_path / "log")
    with (tmp_path / "log" / "log_0.mcap").open("rb") as file:
        assert all(m.log_time == m.publish_time for _, _, m in make_reader(file).iter_messages("/joint_states"))
    assert read_log(tmp_path / "log").provenance["real_time"] is False


@pytest.mark.parametrize(
    ("node", "name", "value", "sentence"),
    [
        ("recorder", "folder", "/elsewhere", r"the run sets it from its argument out; omit it"),
        ("plant", "autostart", False, "parameter autostart of node plant is given, but the run sets it; omit it"),
        ("plant", "observers", 2, "the run sets it"),
        ("controller", "scenario", "circle_pd", "the run sets it from its scenario"),
        ("controller", "motor_1.kq", 1.0, "unknown parameter of node controller 'motor_1.kq': did you mean 'motor_1.k"),
        ("controller", "motor_1.kp", float("nan"), "parameter motor_1.kp of node controller is nan"),
    ],
)
def test_parameter_set_by_the_run_or_unknown_is_bad_input(
    tmp_path: Path, node: str, name: str, value: object, sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        run_scenario("circle_dae", tmp_path / "log", parameters={node: {name: value}})
    assert not (tmp_path / "log").exists()


def test_gain_may_be_given_to_the_controller(tmp_path: Path, log_differences: Differences) -> None:
    run_scenario("circle_dae", tmp_path / "log", parameters={"controller": {"motor_1.kp": 1000.0}})
    assert "joint_commands.effort" in log_differences(direct("circle_dae"), read_log(tmp_path / "log"))


def test_scenario_that_does_not_exist_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown scenario 'circle_dea'.*did you mean 'circle_dae'"):
        run_scenario("circle_dea", tmp_path / "log")


def test_unknown_layout_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown layout 'threads': allowed are composed, processes"):
        run_scenario("circle_dae", tmp_path / "log", "threads")


def test_parameter_that_is_not_a_number_is_bad_input(tmp_path: Path) -> None:
    parameters = {"plant": {"resend_timeout": float("nan")}}
    with pytest.raises(InputError, match="parameter resend_timeout of node plant is nan, allowed is a finite number"):
        run_scenario("circle_dae", tmp_path / "log", parameters=parameters)


def test_folder_that_holds_something_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="exists already; name another one"):
        run_scenario("circle_dae", tmp_path)
