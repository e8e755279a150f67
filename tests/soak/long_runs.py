"""Long runs: memory and file handles of every process over time, and samples that are missing in the log."""

from __future__ import annotations

import shutil
from pathlib import Path

from mcap.reader import make_reader

from tests.soak.result import Result
from tests.soak.starting import await_samples, ending, start_run
from tests.soak.watching import growth, growth_counts, watch

SCENARIO = "regulator_four_mass"
"""Noise in every sample, so that nothing in the loop comes to rest."""

PATIENT = ["--realtime", "--parameter", "plant.real_time_patience=10.0", "--parameter", "feedforward.lead=3.0"]
"""A machine that does other work may keep the feedforward waiting for longer than 0.1 s."""

TOPICS = ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference")
"""Topics with one message for each sample."""


def long_run(folder: Path, layout: str, duration: float, period: float, real_time: bool) -> Result:
    """Run for long and watch the processes.

    Args:
        folder: Folder for the log, which is removed at the end.
        layout: "composed" or "processes".
        duration: Simulated time [s].
        period: Time between two looks at the processes [s].
        real_time: Whether the loop is paced by the wall clock.

    Returns:
        A row for each process, and one for the log.
    """
    folder.mkdir(parents=True, exist_ok=True)
    options = [SCENARIO, "--set", f"duration={duration}", "--layout", layout, *(PATIENT if real_time else [])]
    run = start_run(folder, *options)
    with ending(run):
        await_samples(run, folder, timeout=300.0)
        watched = watch(run.pid, lambda: run.ended, period)
    figures = run.figures()
    result = Result(["process", "memory [MB]", "growth [bytes per sample]", "open files", "threads"])
    if figures["exit_code"]:
        result.add("run", "", "", "", "", wrong=f"exit code {figures['exit_code']}: {figures['message']}")
        return result
    for name, one in watched.items():
        seen = growth(one.samples, figures["samples"] / figures["wall_time_s"])
        result.add(
            name,
            f"{seen.first_mb:.2f} to {seen.last_mb:.2f}",
            f"{seen.slope:.3f} ± {seen.half_width:.3f}",
            " to ".join(map(str, sorted(set(seen.handles)))),
            " to ".join(map(str, sorted(set(seen.threads)))),
            wrong="" if seen.is_flat else "not flat",
        )
        begin, end = one.samples[0][0], one.samples[-1][0]
        for at, opened, closed in one.opened:
            if growth_counts(at, begin, end):
                result.notes.append(
                    f"{name}, {at - begin:.0f} s: opened {', '.join(opened) or 'nothing'}, closed "
                    f"{', '.join(closed) or 'nothing'}."
                )
    counts, size = messages(folder / "log" / "log_0.mcap")
    shutil.rmtree(folder / "log")
    unseen = figures["unseen_samples"]  # neither command nor reference was ever sent for them
    lost = sum(figures["samples"] - counts.get(name, 0) for name in TOPICS) - 2 * unseen
    planned = round(duration * 2000) + 1
    short = f"{figures['samples']} of {planned} samples" if figures["samples"] < planned else ""
    result.add(
        "log",
        f"{size / 1e6:.0f} MB on disk",
        f"{lost} samples lost",
        "",
        "",
        wrong=short or ("samples lost" if lost else "samples unseen" if unseen and not real_time else ""),
    )
    result.notes.append(
        f"{figures['samples']:,} samples of five topics, {figures['simulated_time_s']:.0f} s simulated in "
        f"{figures['wall_time_s']:.0f} s, {figures['samples_per_second']:,.0f} samples/s; {figures['resends']} states "
        "were sent again."
    )
    if real_time:
        result.notes.append(
            f"{figures['late_percent']:.1f} % of the cycles late by more than a tenth, longest period "
            f"{figures['period_max_us'] / 1e3:.1f} ms, {figures['missed_commands']:.0f} samples without command in "
            f"time, {unseen} of which the controller never saw, in parallel with other work of the machine."
        )
    return result


def messages(file: Path) -> tuple[dict[str, int], int]:
    """Count the messages of a log by topic, from its own statistics; give its size too [bytes]."""
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    names = {number: channel.topic.removeprefix("/") for number, channel in summary.channels.items()}
    return {names[n]: count for n, count in summary.statistics.channel_message_counts.items()}, file.stat().st_size
