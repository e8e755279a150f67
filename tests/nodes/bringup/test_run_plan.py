"""Plan and summary of a run."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.scenario.scenario import load_scenario
from flexros_nodes.bringup.run_plan import RunPlan, leader_of, summarise
from flexros_nodes.protocol.node_report import NodeReport

PLANT = NodeReport("plant", figures={"samples": 100, "simulated_time_s": 0.05, "resends": 3, "dropped_on_purpose": 2})


def test_run_without_log_has_no_recorder_and_waits_for_none() -> None:
    plan = RunPlan("circle_pd", None, {})
    assert plan.nodes == ("feedforward", "controller", "plant")
    assert plan.values("plant")["observers"] == 0


def test_identification_leads_a_run_in_the_place_of_feedforward() -> None:
    plan = RunPlan("identify", Path("log"), {}, "identification")
    assert plan.nodes == ("recorder", "identification", "controller", "plant")
    assert RunPlan("circle_pd", Path("log"), {}).nodes == ("recorder", "feedforward", "controller", "plant")


def test_key_of_the_scenario_chooses_the_leader(identification_scenario: Path) -> None:
    assert leader_of(load_scenario(identification_scenario)) == "identification"
    assert leader_of(load_scenario("circle_pd")) == "feedforward"


def test_given_parameters_come_last() -> None:
    plan = RunPlan("circle_pd", Path("log"), {"plant": {"real_time": True}, "recorder": {"niceness": 5}})
    assert plan.real_time
    assert plan.values("plant")["real_time"] is True
    assert plan.values("recorder")["niceness"] == 5


def test_loop_goes_before_reference_and_log_and_these_before_all_else_in_real_time() -> None:
    plan = RunPlan("circle_pd", Path("log"), {"plant": {"real_time": True}})
    priorities = [plan.process_values(node)["priority"] for node in ("plant", "controller", "feedforward", "recorder")]
    assert priorities == [10, 10, 5, 5]
    assert "priority" not in RunPlan("circle_pd", Path("log"), {}).process_values("recorder")


def test_recorder_gets_folder_and_pace() -> None:
    plan = RunPlan("circle_pd", Path("log"), {"plant": {"real_time": True}})
    assert plan.values("recorder")["folder"] == "log"
    assert plan.values("recorder")["real_time"] is True
    assert RunPlan("circle_pd", Path("log"), {}).values("recorder")["real_time"] is False


def test_counts_are_added_up() -> None:
    controller = NodeReport("controller", figures={"dropped_on_purpose": 4})
    recorder = NodeReport(
        "recorder", figures={"joint_states.missing": 1, "tool_pose.missing": 2, "tool_pose.messages": 9}
    )
    reports = {report.node: report for report in (PLANT, controller, recorder)}
    summary = summarise(reports, Path("log"), "composed", interrupted=False)
    assert (summary.samples, summary.resends, summary.dropped, summary.missing) == (100, 3, 6, 3)
    assert (summary.exit_code, summary.message) == (0, "")


def test_a_sample_the_controller_never_saw_is_not_missing_in_the_log() -> None:
    controller = NodeReport("controller", figures={"missed_states": 5})
    recorder = NodeReport("recorder", figures={"joint_commands.missing": 5, "joint_reference.missing": 7})
    summary = summarise({"controller": controller, "recorder": recorder}, Path("log"), "composed", interrupted=False)
    assert (summary.unseen, summary.missing) == (5, 2)


def test_message_of_the_cause_precedes_that_of_the_plant() -> None:
    reports = {
        "plant": NodeReport("plant", 3, "no command"),
        "controller": NodeReport("controller", 3, "measurement refused"),
    }
    summary = summarise(reports, None, "composed", interrupted=False)
    assert summary.message.startswith("measurement refused; no command")


def test_bad_input_outranks_nothing_but_what_is_done() -> None:
    reports = {"plant": PLANT, "controller": NodeReport("controller", 2, "bad gain")}
    assert summarise(reports, None, "composed", interrupted=False).exit_code == 2


def test_death_of_a_process_aborts_the_run() -> None:
    summary = summarise({}, None, "processes", interrupted=False, deaths=("the process of node plant was killed",))
    assert summary.exit_code == 3
    assert summary.message.startswith("the process of node plant was killed")


RECORDED = NodeReport("recorder", figures={"joint_states.messages": 700})


@pytest.mark.parametrize(
    ("reports", "exists", "end"),
    [
        ({"recorder": RECORDED}, True, "killed; the log is valid up to that point"),
        (
            {"recorder": NodeReport("recorder", figures={"joint_states.messages": 0})},
            True,
            "; the log holds no samples",
        ),
        ({"recorder": NodeReport("recorder")}, False, "killed; there is no log"),
        ({"recorder": NodeReport("recorder", 3, "the disk is full")}, True, "killed; the disk is full"),
        ({}, True, "to see how far the log reaches"),
    ],
    ids=["readable", "empty", "none", "recorder failed", "recorder killed"],
)
def test_state_of_the_log_is_reported(tmp_path: Path, reports: dict[str, NodeReport], exists: bool, end: str) -> None:
    folder = tmp_path / "log"
    if exists:
        folder.mkdir()
    summary = summarise(reports, folder, "processes", interrupted=False, deaths=("killed",))
    assert summary.message.endswith(end)
    assert summary.log_folder == (folder if exists else None)


def test_aborted_run_without_a_log_reports_it() -> None:
    summary = summarise({}, None, "composed", interrupted=True)
    assert summary.message == "interrupted; no recording was requested"


def test_samples_come_from_the_recorder_when_the_plant_left_no_report(tmp_path: Path) -> None:
    summary = summarise({"recorder": RECORDED}, tmp_path, "processes", interrupted=False, deaths=("killed",))
    assert summary.samples == 700


def test_interruption_is_reported_unless_something_failed() -> None:
    assert summarise({"plant": PLANT}, None, "composed", interrupted=True).exit_code == 130
    broken = {"plant": NodeReport("plant", 3, "no command")}
    assert summarise(broken, None, "composed", interrupted=True).exit_code == 3


@pytest.mark.parametrize(
    ("at", "message"),
    [(900.0, "stopped by the service stop at sample 900: 3 of 8 experiments are complete"), (-1.0, "")],
)
def test_stopped_identification_is_complete_and_reported(at: float, message: str) -> None:
    figures = {"stopped_at_sample": at, "completed": 3.0, "planned": 8.0}
    reports = {"identification": NodeReport("identification", figures=figures), "plant": PLANT}
    summary = summarise(reports, None, "composed", interrupted=False)
    assert (summary.exit_code, summary.message) == (0, message)
