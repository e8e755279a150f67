"""Nodes frozen (SIGSTOP) for a short and for a long time."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Sequence
from pathlib import Path

import psutil

from flexros.logs.reader import read_log
from tests.nodes.conftest import differences
from tests.soak.result import Result, differing
from tests.soak.starting import await_samples, direct_log, ending, samples_in, scenario_file, start_run
from tests.soak.watching import name_of

NODES = ("plant", "controller", "feedforward", "recorder")
SHORT, LONG = 0.5, 9.0
"""Times for which a node is frozen [s]; time-outs lie between them."""
PATIENCE = (("plant.partner_timeout", 5), ("plant.recorder_timeout", 5), ("plant.brake_duration", 0.05))


def frozen(
    folder: Path, victims: Sequence[str] = NODES, times: Sequence[float] = (SHORT, LONG), duration: float = 10.0
) -> Result:
    """Freeze a node of a run in lock-step, and let it go on.

    For a short time nobody may notice, and the log is that of an undisturbed run. A plant may be frozen for as long as
    one likes. For the others the plant gives up after its time-out, brakes and says so.
    """
    result = Result(["frozen", "time [s]", "exit code", "message of the run", "log"])
    options = [word for key, value in PATIENCE for word in ("--parameter", f"{key}={value}")]
    for seconds in times:
        for victim in victims:
            work = folder / f"{victim}{seconds}"
            work.mkdir(parents=True)
            scenario = scenario_file(work, "circle_dae", duration if seconds < 1.0 else 60.0)
            run = start_run(work, str(scenario), "--layout", "processes", *options)
            with ending(run):
                await_samples(run, work)
                _freeze(run.pid, victim, seconds)
                survives = seconds < 1.0 or victim == "plant"
                code = run.exit_code(600.0)
            samples = samples_in(work / "log")
            wrong = [f"exit code {code}"] * (code != (0 if survives else 3))
            if survives and code == 0:
                wrong += (
                    [differing("the log", found)]
                    if (found := differences(direct_log(scenario), read_log(work / "log")))
                    else []
                )
            wrong += ["nothing said"] * (not survives and "the plant has braked" not in run.last_sentence())
            what = "equal in every bit" if survives and not wrong else f"readable, {samples} samples"
            result.add(victim, f"{seconds:g}", str(code), run.last_sentence(), what, wrong="; ".join(wrong))
            shutil.rmtree(work)
    return result


def frozen_in_real_time(folder: Path, times: Sequence[float] = (0.04, 0.5)) -> Result:
    """Freeze the controller of a run in real time, for less and for more than `real_time_patience` (0.1 s)."""
    result = Result(["frozen", "time [s]", "exit code", "message of the run", "samples without command"])
    for seconds in times:
        work = folder / f"real_time{seconds}"
        work.mkdir(parents=True)
        run = start_run(work, str(scenario_file(work, "circle_dae", 6.0)), "--layout", "processes", "--realtime")
        with ending(run):
            await_samples(run, work, 30_000)
            _freeze(run.pid, "controller", seconds)
            code = run.exit_code()
        survives = seconds < 0.1
        figures = run.figures()
        missed, unseen = figures["missed_commands"], figures["unseen_samples"]
        wrong = [f"exit code {code}"] * (code != (0 if survives else 3)) + ["no miss counted"] * (not missed)
        wrong += [f"the controller never saw {unseen} samples"] * (survives and bool(unseen))
        result.add(
            "controller", f"{seconds:g}", str(code), run.last_sentence(), f"{missed:.0f}", wrong="; ".join(wrong)
        )
        shutil.rmtree(work)
    return result


def _freeze(pid: int, victim: str, seconds: float) -> None:
    children = {name_of(one): one for one in psutil.Process(pid).children()}
    children[victim].send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    if children[victim].is_running():  # a run that has given up ends what does not answer
        children[victim].send_signal(signal.SIGCONT)
