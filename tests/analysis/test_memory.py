"""Memory of a long log: run, read, analysed and reported below 400 bytes per sample, 1.5 GB for half an hour at 2 kHz.

Measured on logs of e12, beyond what a short one needs.
"""

from __future__ import annotations

import tracemalloc

import pytest

from flexros.analysis import analyse
from flexros.analysis.report import write_report
from flexros.logs.reader import read_log
from flexros.robot import load_robot
from flexros.scenario.scenario import load_scenario
from flexros.scenario.transports import run_direct

SAMPLES = 40_001
MOST_BYTES = 400
"""Largest memory per sample of e12: (1.5 GB - 0.15 GB of the program) / 3.36 million samples."""


def scenario(seconds, repeats):
    """The circle test, again and again."""
    return load_scenario("circle_dae").with_values({"duration": seconds, "trajectory.repeat": repeats})


def reported(bag):
    """Read a log, analyse it, and write its report."""
    log = read_log(bag)
    analysis = analyse(log, robot=load_robot("e12"))
    write_report([analysis], bag.with_suffix(".html"))
    return log, analysis


def peak(step, *given):
    """Return the result of a step, and the largest memory that it takes beyond what was there before [bytes]."""
    tracemalloc.start()
    try:
        return step(*given), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
def test_memory_per_sample(tmp_path):
    short, again, long = tmp_path / "short", tmp_path / "again", tmp_path / "long"
    run_direct(scenario(1.0, 2), short)
    reported(short)  # imports and machine code
    _, page = peak(reported, short)
    _, start = peak(run_direct, scenario(1.0, 2), again)
    _, run = peak(run_direct, scenario((SAMPLES - 1) * 5e-4, 50), long)
    (log, analysis), report = peak(reported, long)
    assert len(log.joint_states.stamp) == SAMPLES
    assert analysis.performance.cycles > 30
    assert (run - start) / SAMPLES < MOST_BYTES
    assert (report - page) / SAMPLES < MOST_BYTES
    assert log.tool_reference.stamp is log.joint_states.stamp  # one array in lock-step
