"""Progress of an identification experiment: state, message and schedule."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import RunError
from flexros.logs.cdr_cursor import CdrCursor, MessageError

if TYPE_CHECKING:
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Segment

STATES = ("waiting", "running", "stopping", "done")
"""Before the start, running as planned, being stopped or at rest after a stop, and at the end of the plan."""

LARGEST_NUMBER = 1e15
"""Largest number in a message, chosen; JSON allows numbers beyond the range of a float."""

_TYPES = {"state": str, "recording": bool, "percent": float, "time_left_s": float} | dict.fromkeys(
    (
        *("position", "positions", "block", "blocks", "experiment", "experiments"),
        *("completed", "planned", "last_sample", "stopped_at_sample"),
    ),
    int,
)
"""Type of the value of each key of a message."""

STEEPEST = 1.875
"""Largest slope of the time scaling of a stop, multiplied by its duration; see `RowsToRest`."""


@dataclass(frozen=True)
class ExperimentState:
    """State of an experiment at one sample; positions, blocks and experiments are numbered from 1.

    Attributes:
        state: One of STATES.
        recording: Whether evaluated periods are being recorded; else the robot moves, settles or the excitation fades.
        position: Present position, or the one the robot moves to.
        positions: Number of positions of the plan.
        block: Block in that position.
        blocks: Blocks in that position.
        experiment: Experiment in that block.
        experiments: Experiments in that block.
        completed: Completed experiments of the whole plan.
        planned: Number of experiments of the whole plan.
        percent: Elapsed share of the time [%].
        time_left_s: Simulated time until the run ends [s].
        last_sample: Last sample of the run.
        stopped_at_sample: First sample that may differ from the plan; -1 unless stopped.
    """

    state: str
    recording: bool
    position: int
    positions: int
    block: int
    blocks: int
    experiment: int
    experiments: int
    completed: int
    planned: int
    percent: float
    time_left_s: float
    last_sample: int
    stopped_at_sample: int = -1

    def as_dict(self) -> dict[str, Any]:
        """Return the state as plain data."""
        return asdict(self)

    def as_json(self) -> str:
        """Return the state as JSON."""
        return json.dumps(self.as_dict())

    def numbers(self) -> dict[str, float]:
        """Return the numbers by name, for diagnostics and report."""
        names = (
            "position",
            "block",
            "experiment",
            "completed",
            "planned",
            "percent",
            "time_left_s",
            "stopped_at_sample",
        )
        return {name: float(getattr(self, name)) for name in names}

    def sentence(self) -> str:
        """Return the state in words."""
        where = (
            f"position {self.position} of {self.positions}, block {self.block} of {self.blocks}, experiment "
            f"{self.experiment} of {self.experiments}"
        )
        if self.state == "waiting":
            return "waiting for the service start"
        if self.state == "stopping" and self.stopped_at_sample == 0:
            return "stopped before the start; no experiment was run"
        if self.state == "stopping":
            return f"stopped at {where}; {self.completed} of {self.planned} experiments are complete"
        if self.state == "done":
            return f"all {self.planned} experiments are complete"
        activity = "recording" if self.recording else "moving to"
        return f"{activity} {where}; {self.percent:.1f} % done, {self.time_left_s:.0f} s left"


def read_experiment_state(message: bytes) -> ExperimentState:
    """Decode a serialised std_msgs/msg/String with the JSON of `ExperimentState.as_json`.

    Raises:
        RunError: The message has other content.
    """
    try:
        values = json.loads(CdrCursor(message).string("data"))
        state = ExperimentState(**values)
        for name, expected in _TYPES.items():
            value = getattr(state, name)
            if type(value) is not expected and not (expected is float and type(value) is int):
                raise ValueError(f"{name} is {value!r}, required is a value of type {expected.__name__}")
            if isinstance(value, (int, float)) and not abs(value) <= LARGEST_NUMBER:  # also rejects NaN
                raise ValueError(f"{name} must be a number of at most {LARGEST_NUMBER:g}")
        if state.state not in STATES:
            raise ValueError(f"state is '{state.state}', allowed are {', '.join(STATES)}")
    except (TypeError, ValueError, RecursionError, MessageError) as error:
        raise RunError(
            f"a message on experiment_state is rejected: {error}; required is JSON with the keys "
            f"{', '.join(field.name for field in fields(ExperimentState))}; correct its sender"
        ) from error
    return state


class ExperimentCourse:
    """Computes the progress of an experiment plan at any sample."""

    def __init__(self, plan: ExperimentPlan) -> None:
        self._plan = plan
        self._segments = plan.segments
        self._n_positions = len(plan.positions)
        self._sample_time = plan.sample_time
        self._last = plan.n_samples - 1
        self._sizes = _sizes(plan.segments)

    def n_completed(self, sample: int) -> int:
        """Count the experiments completed before a sample."""
        return sum(segment.stop <= sample for segment in self._segments)

    def n_slowing(self, first: int) -> int:
        """Return the number of samples in which a stop that begins at sample `first` brings the robot to rest.

        During an experiment it is the fade time. In a move, where that may be too short, it is long enough for braking
        to stay within the acceleration of the move.
        """
        if first == 0:
            return 1  # the experiment has not begun
        specification = self._plan.specification
        time, move = specification.fade, specification.move
        for visit in self._plan.visits:
            if visit.begin_first <= first < visit.begin_first + visit.n_experiments * visit.experiment:
                break
        else:
            time = max(time, STEEPEST * float(np.max(np.asarray(move.speed) / np.asarray(move.acceleration))))
        return max(round(time / self._sample_time), 1)

    def state(self, state: str, sample: int, stopped: tuple[int, int] | None = None) -> ExperimentState:
        """Return the state.

        Args:
            state: One of STATES.
            sample: Newest known sample of the loop.
            stopped: First sample that may differ from the plan, and last sample of the run; None unless stopped.
        """
        stop, last = (-1, self._last) if stopped is None else stopped
        completed = self.n_completed(sample if stopped is None else stop)  # up to the stop all is as planned
        segment = self._segments[min(completed, len(self._segments) - 1)]
        blocks, experiments = self._sizes[segment.position]
        return ExperimentState(
            state=state,
            recording=state == "running" and segment.first <= sample < segment.stop,
            position=segment.position + 1,
            positions=self._n_positions,
            block=segment.block + 1,
            blocks=blocks,
            experiment=segment.experiment + 1,
            experiments=experiments,
            completed=completed,
            planned=len(self._segments),
            percent=round(100.0 * min(sample / max(last, 1), 1.0), 3),
            time_left_s=round(max(last - sample, 0) * self._sample_time, 6),
            last_sample=last,
            stopped_at_sample=stop,
        )


def _sizes(segments: tuple[Segment, ...]) -> dict[int, tuple[int, int]]:
    """Return the number of blocks, and of experiments per block, by position."""
    sizes: dict[int, tuple[int, int]] = {}
    for segment in segments:
        blocks, experiments = sizes.get(segment.position, (0, 0))
        sizes[segment.position] = max(blocks, segment.block + 1), max(experiments, segment.experiment + 1)
    return sizes
