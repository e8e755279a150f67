"""How far an identification experiment is, as nodes and services tell it; free of ROS."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import RunError
from flexros.logs.messages.cdr_cursor import CdrCursor, MessageError

if TYPE_CHECKING:
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Segment

STATES = ("waiting", "running", "stopping", "done")
"""Before its start, under way as planned, being brought to rest or at rest after that, and at the end of the plan."""

MOST = 1e15
"""Largest number in a message; JSON knows larger ones than a float holds (chosen)."""

_KINDS = {"state": str, "recording": bool, "percent": float, "time_left_s": float} | dict.fromkeys(
    (
        *("position", "positions", "block", "blocks", "experiment", "experiments"),
        *("completed", "planned", "last_sample", "stopped_at_sample"),
    ),
    int,
)
"""Kind of the value of each key of a message."""

STEEPEST = 1.875
"""Largest slope of the rate at which a stopped plan is gone, times the time that the stop takes; see `RowsToRest`."""


@dataclass(frozen=True)
class ExperimentState:
    """State of an experiment at one sample; numbers of positions, blocks and experiments count from 1.

    Attributes:
        state: One of STATES.
        recording: Whether the periods that count are being recorded; else the robot moves, settles or fades.
        position: Position at which the robot is, or to which it moves.
        positions: Number of positions of the plan.
        block: Block in that position.
        blocks: Blocks in that position.
        experiment: Experiment in that block.
        experiments: Experiments in that block.
        completed: Experiments of the whole plan whose recorded periods are complete.
        planned: Experiments of the whole plan.
        percent: Share of the time that is over [%].
        time_left_s: Simulated time until the run ends [s].
        last_sample: Sample with which the run ends.
        stopped_at_sample: First sample that may differ from the plan; -1 unless it was stopped.
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
        """Give it as plain data."""
        return asdict(self)

    def as_json(self) -> str:
        """Write it as JSON."""
        return json.dumps(self.as_dict())

    def numbers(self) -> dict[str, float]:
        """Give the numbers by name, for diagnostics and report."""
        kept = (
            "position",
            "block",
            "experiment",
            "completed",
            "planned",
            "percent",
            "time_left_s",
            "stopped_at_sample",
        )
        return {name: float(getattr(self, name)) for name in kept}

    def sentence(self) -> str:
        """Say it in words."""
        where = (
            f"position {self.position} of {self.positions}, block {self.block} of {self.blocks}, experiment "
            f"{self.experiment} of {self.experiments}"
        )
        if self.state == "waiting":
            return "waiting for the service start"
        if self.state == "stopping" and self.stopped_at_sample == 0:
            return "stopped before it began; no experiment was run"
        if self.state == "stopping":
            return f"stopped at {where}; {self.completed} of {self.planned} experiments are complete"
        if self.state == "done":
            return f"all {self.planned} experiments are complete"
        doing = "recording" if self.recording else "on the way to"
        return f"{doing} {where}; {self.percent:.1f} % done, {self.time_left_s:.0f} s left"


def read_experiment_state(message: bytes) -> ExperimentState:
    """Read a message that carries what `as_json` has written.

    Args:
        message: Serialised std_msgs/msg/String.

    Returns:
        The state.

    Raises:
        RunError: It is something else.
    """
    try:
        given = json.loads(CdrCursor(message).string("data"))
        state = ExperimentState(**given)
        for name, kind in _KINDS.items():
            value = getattr(state, name)
            if type(value) is not kind and not (kind is float and type(value) is int):
                raise ValueError(f"{name} is {value!r}, needed is a value of type {kind.__name__}")
            if isinstance(value, (int, float)) and not abs(value) <= MOST:  # NaN is not, either
                raise ValueError(f"{name} must be a number of at most {MOST:g}")
        if state.state not in STATES:
            raise ValueError(f"state is '{state.state}', allowed are {', '.join(STATES)}")
    except (TypeError, ValueError, RecursionError, MessageError) as error:
        raise RunError(
            f"a message on experiment_state is refused: {error}; needed is JSON with the keys "
            f"{', '.join(field.name for field in fields(ExperimentState))}; correct its sender"
        ) from error
    return state


class ExperimentCourse:
    """Tells at any sample of a plan how far the experiment is.

    Args:
        plan: The plan.
    """

    def __init__(self, plan: ExperimentPlan) -> None:
        self._plan = plan
        self._segments = plan.segments
        self._n_positions = len(plan.positions)
        self._sample_time = plan.sample_time
        self._last = plan.n_samples - 1
        self._sizes = _sizes(plan.segments)

    def number(self, sample: int) -> int:
        """Count the experiments whose recorded periods are complete before a sample."""
        return sum(segment.stop <= sample for segment in self._segments)

    def slowing(self, first: int) -> int:
        """Give the samples in which the robot comes to rest when it is stopped.

        Args:
            first: First sample of the stop.

        Returns:
            The fade time during an experiment. In a move, where that may be too short, so many that braking needs no
            more than the acceleration of the move.
        """
        if first == 0:
            return 1  # it has not begun
        specification = self._plan.specification
        time, move = specification.fade, specification.move
        for visit in self._plan.visits:
            if visit.begin_first <= first < visit.begin_first + visit.n_experiments * visit.experiment:
                break
        else:
            time = max(time, STEEPEST * float(np.max(np.asarray(move.speed) / np.asarray(move.acceleration))))
        return max(round(time / self._sample_time), 1)

    def state(self, state: str, sample: int, stopped: tuple[int, int] | None = None) -> ExperimentState:
        """Give the state.

        Args:
            state: One of STATES.
            sample: Newest sample of the loop that is known.
            stopped: First sample that may differ from the plan, and last sample of the run; None if it was not stopped.
        """
        at, last = (-1, self._last) if stopped is None else stopped
        completed = self.number(
            sample if stopped is None else at
        )  # the robot goes as planned up to there, so it counts
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
            stopped_at_sample=at,
        )


def _sizes(segments: tuple[Segment, ...]) -> dict[int, tuple[int, int]]:
    """Give the number of blocks, and of experiments in a block, by position."""
    sizes: dict[int, tuple[int, int]] = {}
    for segment in segments:
        blocks, experiments = sizes.get(segment.position, (0, 0))
        sizes[segment.position] = max(blocks, segment.block + 1), max(experiments, segment.experiment + 1)
    return sizes
