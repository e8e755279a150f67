"""One log of a case: the run with the noise of encoders and tracker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import BASE_FRAME, JointSeries, Log, PoseSeries
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.draw.conditions import Conditions, Tracker, encoder_noise
from flexros.validation.blind.draw.sizing import SETTLE, TOOL_STEP, events
from flexros.validation.blind.plant.plant import BlindInputs, BlindPlant
from flexros.validation.blind.plant.tool_view import seen_pose

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.robot import Robot
    from flexros.validation.blind.make_case import Drawn

PROVENANCE = {"scenario": {"name": "blind"}}
"""All that the side-car of a log says: that it was simulated."""


@dataclass(frozen=True, eq=False)
class RecordedLog:
    """A recording.

    Attributes:
        names: Names of the motors.
        sample_time: Time between two samples [s].
        stamp: Stamps of the samples [ns], shape (n,).
        encoder: Encoder values [rad or m], shape (n, M).
        command: Commands [Nm or N], shape (n, M).
        reference: Reference positions, speeds and torques, shape (n, 3 M).
        tool: Positions of the tool as the tracker saw them every `TOOL_STEP` [m], shape (n_t, 3); None without tracker.
    """

    names: tuple[str, ...]
    sample_time: float
    stamp: IntArray
    encoder: FloatArray
    command: FloatArray
    reference: FloatArray
    tool: FloatArray | None

    def log(self) -> Log:
        """Convert the record to a log; references and tool poses have a period of 4 ms."""
        m, seldom = len(self.names), slice(None, None, round(TOOL_STEP / self.sample_time))
        even = stamps_ns(len(self.encoder), self.sample_time)[seldom]
        wanted = self.reference[seldom]
        tool = self.tool
        upright = np.array([0.0, 0.0, 0.0, 1.0])
        return Log(
            joint_states=JointSeries(self.stamp, self.names, position=self.encoder),
            joint_commands=JointSeries(self.stamp, self.names, effort=self.command),
            joint_reference=JointSeries(
                even,
                self.names,
                position=np.ascontiguousarray(wanted[:, :m]),
                velocity=np.ascontiguousarray(wanted[:, m : 2 * m]),
            ),
            tool_pose=None if tool is None else PoseSeries(even, BASE_FRAME, tool, np.tile(upright, (len(tool), 1))),
            provenance=PROVENANCE,
        )


def record_log(drawn: Drawn, tool: bool, place: int, duration: float, random: np.random.Generator) -> RecordedLog:
    """Run a case once with noise.

    Args:
        drawn: The case.
        tool: Whether the tool is measured.
        place: Number of the log; the first one has the reference of the case, the last one moves at random.
        duration: Its length, about [s].
        random: Random numbers of this log.

    Returns:
        What was recorded.

    Raises:
        UnstableCaseError: The loop ran away.
    """
    setting, conditions = drawn.setting, drawn.conditions
    robot, step = setting.robot, setting.sample_time
    reference = drawn.reference if place == 0 else setting.reference(duration, random, "random" if place == 2 else "")
    deviations = tuple(one.deviation for one in drawn.hidden)
    plant = BlindPlant(robot, (*deviations, *_rounding(robot, conditions)), setting.law, step)
    n, m = len(reference), robot.n_motors
    lost, push = events(deviations, n, step, random)
    late = conditions.late * np.repeat(random.standard_normal((n, 1)), m, axis=1)
    noise = encoder_noise(robot.encoder_noise, n, conditions.colour, random)
    run = plant.run(BlindInputs(reference, noise, late, lost, push), SETTLE)
    seen = None
    if tool:
        states = _later(run.states, conditions.tool_late / step)[:: round(TOOL_STEP / step)]
        pose = seen_pose(robot, deviations, states, plant.robot)
        seen = Tracker.draw(robot, random).see(pose, random)
    return RecordedLog(
        robot.joint_names, step, _stamps(n, step, conditions, random), run.encoder, run.command, reference, seen
    )


def _rounding(robot: Robot, conditions: Conditions) -> tuple[Deviation, ...]:
    """Return the rounding of encoders, which the plant simulates like a deviation; none where they do not round."""
    if not conditions.encoder_step:
        return ()
    return tuple(
        Deviation(
            effect="encoder_quantization", location=name, parameters={"step": conditions.encoder_step * float(noise)}
        )
        for name, noise in zip(robot.joint_names, robot.encoder_noise, strict=True)
    )


def _later(states: FloatArray, samples: float) -> FloatArray:
    """Shift states by a part of a sample or several."""
    at = np.clip(np.arange(len(states)) + samples, 0, len(states) - 1)
    low = np.minimum(np.floor(at).astype(int), len(states) - 2)
    share = (at - low)[:, None]
    return np.asarray((1 - share) * states[low] + share * states[low + 1])


def _stamps(n: int, sample_time: float, conditions: Conditions, random: np.random.Generator) -> IntArray:
    """Stamp the samples, with the jitter of the clock."""
    even = stamps_ns(n, sample_time)
    if not conditions.stamps:
        return even
    jitter = np.clip(random.standard_normal(n) * conditions.stamps, -0.3 * sample_time, 0.3 * sample_time)
    stamp: IntArray = even + np.rint(jitter * 1e9).astype(np.int64)
    return stamp
