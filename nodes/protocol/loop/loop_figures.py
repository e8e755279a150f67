"""What a plant tells of its loop, by the keys of the diagnostics; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros_nodes.protocol.loop.lockstep import PlantLockStep
    from flexros_nodes.protocol.loop.message_loss import MessageLoss
    from flexros_nodes.protocol.loop.shutdown import Ending
    from flexros_nodes.protocol.real_time.held_command import HeldCommand
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics
    from flexros_nodes.protocol.recorder.recorder_window import RecorderWindow


def loop_figures(
    simulated_time: float,
    samples: int,
    wall_time: float,
    lockstep: PlantLockStep,
    loss: MessageLoss,
    window: RecorderWindow,
    ending: Ending | None,
) -> dict[str, float]:
    """Give counts and speed.

    Args:
        simulated_time: Time that the samples cover [s].
        samples: Samples of the loop.
        wall_time: Time that they took [s].
        lockstep: Counts what was sent again.
        loss: Counts what was lost on purpose.
        window: Counts the waits for the recorder.
        ending: Counts the samples of the end, if it has come.
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
        "braked_samples": ending.braked if ending else 0,
    }


def timing_figures(prioritised: bool, newest: HeldCommand | None, cycles: PeriodStatistics | None) -> dict[str, float]:
    """Give what diagnostics and report show of the schedule of a run in real time.

    Args:
        prioritised: Whether the thread that paces the node has real-time priority.
        newest: Counts the samples whose command came too late; None before the first cycle.
        cycles: Period and lateness; None before the first cycle.

    Returns:
        Figures by name; missed commands count from the first cycle on.
    """
    if newest is None or cycles is None:
        return {"missed_commands": 0, "real_time_priority": prioritised}
    return {"missed_commands": newest.missed, "real_time_priority": prioritised, **cycles.as_dict()}
