"""What a run consists of and how it is summed up."""

from __future__ import annotations

from pathlib import Path

from flexros_nodes.report import NodeReport
from flexros_nodes.run_plan import RunPlan, summarise

PLANT = NodeReport("plant", figures={"samples": 100, "simulated_time_s": 0.05, "resends": 3, "dropped_on_purpose": 2})


def test_run_without_log_has_no_recorder_and_waits_for_none() -> None:
    plan = RunPlan("circle_pd", None, {})
    assert plan.nodes == ("feedforward", "controller", "plant")
    assert plan.values("plant")["observers"] == 0


def test_given_parameters_come_last() -> None:
    plan = RunPlan("circle_pd", Path("log"), {"plant": {"real_time": True, "observers": 2}})
    assert plan.real_time
    assert plan.values("plant")["observers"] == 2
    assert plan.values("recorder")["folder"] == "log"


def test_counts_are_added_up() -> None:
    controller = NodeReport("controller", figures={"dropped_on_purpose": 4})
    recorder = NodeReport(
        "recorder", figures={"joint_states.missing": 1, "tool_pose.missing": 2, "tool_pose.messages": 9}
    )
    reports = {report.node: report for report in (PLANT, controller, recorder)}
    summary = summarise(reports, Path("log"), "composed", interrupted=False)
    assert (summary.samples, summary.resends, summary.dropped, summary.missing) == (100, 3, 6, 3)
    assert (summary.exit_code, summary.message) == (0, "")


def test_cause_comes_before_the_plant_that_noticed() -> None:
    reports = {
        "plant": NodeReport("plant", 3, "no command"),
        "controller": NodeReport("controller", 3, "measurement refused"),
    }
    summary = summarise(reports, None, "composed", interrupted=False)
    assert summary.message == "measurement refused; no command"


def test_bad_input_outranks_nothing_but_what_is_done() -> None:
    reports = {"plant": PLANT, "controller": NodeReport("controller", 2, "bad gain")}
    assert summarise(reports, None, "composed", interrupted=False).exit_code == 2


def test_death_of_a_process_breaks_the_run_off() -> None:
    summary = summarise({}, None, "processes", interrupted=False, deaths=("the process of node plant was killed",))
    assert (summary.exit_code, summary.message) == (3, "the process of node plant was killed")


def test_interruption_is_told_unless_something_broke() -> None:
    assert summarise({"plant": PLANT}, None, "composed", interrupted=True).exit_code == 130
    broken = {"plant": NodeReport("plant", 3, "no command")}
    assert summarise(broken, None, "composed", interrupted=True).exit_code == 3
