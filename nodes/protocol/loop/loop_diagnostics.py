"""Diagnostics of the plant loop: figures by key, and warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.protocol.loop.torque_use import SAMPLES_AT_LIMIT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros_nodes.protocol.loop.lockstep import PlantLockStep
    from flexros_nodes.protocol.loop.message_loss import MessageLoss
    from flexros_nodes.protocol.loop.shutdown import Shutdown
    from flexros_nodes.protocol.recorder.recorder_window import RecorderWindow

LATE_PERCENT = 5.0
"""Share of late cycles above which the plant warns [%], chosen: what a recorder on the same machine may cost."""


def loop_figures(
    simulated_time: float,
    samples: int,
    wall_time: float,
    lockstep: PlantLockStep,
    loss: MessageLoss,
    window: RecorderWindow,
    shutdown: Shutdown | None,
) -> dict[str, float]:
    """Return counts and speed of the loop by diagnostics key.

    Args:
        simulated_time: Time covered by the samples [s].
        samples: Number of samples of the loop.
        wall_time: Wall-clock time that they took [s].
        lockstep: Counts repeated states.
        loss: Counts messages dropped on purpose.
        window: Counts waits for the recorder.
        shutdown: Counts brake samples; None while the loop runs.
    """
    wall = max(wall_time, 1e-9)
    return {
        "samples": samples,
        "simulated_time_s": simulated_time,
        "wall_time_s": wall,
        "samples_per_s": samples / wall,
        "resends": lockstep.resends,
        "stale_commands": lockstep.stale,
        "dropped_on_purpose": loss.dropped,
        "waits_for_recorder": window.waits,
        "braked_samples": shutdown.braked if shutdown else 0,
    }


def loop_warnings(figures: Mapping[str, float], previous: Mapping[str, float], controllers: int) -> list[str]:
    """Return a warning for each fault since the last diagnostics message.

    Args:
        figures: Figures of the plant: counts since the beginning, timing since the last message.
        previous: Figures of the last message.
        controllers: Number of nodes that publish joint_commands.
    """

    def increase(name: str) -> int:
        count, last = figures.get(name, 0), previous.get(name, 0)
        return int(count - last if count >= last else count)  # a reset loop counts from zero

    warnings = [f"{controllers} nodes publish joint_commands"] if controllers > 1 else []
    for name in figures:
        if name.endswith(SAMPLES_AT_LIMIT) and increase(name):
            warnings.append(f"{name.removesuffix(SAMPLES_AT_LIMIT)} at its torque limit in {increase(name)} samples")
    if missed := increase("missed_commands"):
        warnings.append(f"{missed} commands came too late")
    if (late := figures.get("late_percent", 0.0)) > LATE_PERCENT:
        warnings.append(f"{late:.0f} % of the cycles began late")
    return warnings
