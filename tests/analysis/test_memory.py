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

SAMPLES = 20_001
MOST_BYTES = 400
"""Largest memory per sample of e12: (1.5 GB - 0.15 GB of the program) / 3.36 million samples."""


def scenario(seconds, repeats):
    """The circle test, again and again."""
    return load_scenario("circle_dae").with_values({"duration": seconds, "trajectory.repeat": repeats})


def memory(step, *given):
    """Return the result of a step, the largest memory that it takes beyond what was there before, and what it keeps."""
    tracemalloc.start()
    try:
        result = step(*given)
        kept, largest = tracemalloc.get_traced_memory()
        return result, largest, kept
    finally:
        tracemalloc.stop()


def analysed(log):
    """Analyse a log of the circle test."""
    return analyse(log, robot=load_robot("e12"))


def reported(bag):
    """Read a log, analyse it, and write its report; return the log, the analysis, and the largest memory of each step.

    The steps are measured apart: writing a page takes much memory whatever the log, in which that of the others would
    not show.
    """
    log, reading, of_log = memory(read_log, bag)
    analysis, analysing, of_analysis = memory(analysed, log)
    _, writing, _ = memory(write_report, [analysis], bag.with_suffix(".html"))
    return log, analysis, [reading, of_log + analysing, of_log + of_analysis + writing]


@pytest.mark.slow
def test_memory_per_sample(tmp_path):
    short, again, long = tmp_path / "short", tmp_path / "again", tmp_path / "long"
    run_direct(scenario(1.0, 2), short)
    write_report([analysed(read_log(short))], tmp_path / "first.html")  # imports and machine code
    _, _, least = reported(short)
    _, start, _ = memory(run_direct, scenario(1.0, 2), again)
    _, run, _ = memory(run_direct, scenario((SAMPLES - 1) * 5e-4, 25), long)
    log, analysis, most = reported(long)
    assert len(log.joint_states.stamp) == SAMPLES
    assert analysis.performance.cycles > 15
    per_sample = [(large - small) / SAMPLES for small, large in zip([start, *least], [run, *most], strict=True)]
    assert max(per_sample) < MOST_BYTES, per_sample
    assert log.tool_reference.stamp is log.joint_states.stamp  # one array in lock-step
