"""Designs of the monitor for the poses of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.design import Design, design, motorwise_gain
from flexros.monitor.pose_model import PoseModel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.monitor.design import LinearFilter
    from flexros.monitor.pose_model import LinearPose

PITCH = 0.4
"""Size of a cell of poses with one design, per motor [rad or m] (chosen): floors change by 2 % within it."""
MOST = 256
"""Most designs that are kept (chosen)."""
BLOCK = 5e-3
"""Time between two values of the disturbance torque [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class PoseDesign:
    """A design, and its filter for several samples at once.

    Attributes:
        design: The design.
        lifted: Its filter for a block of samples.
    """

    design: Design
    lifted: LinearFilter


class DesignBook:
    """Computes designs and keeps them.

    Args:
        model: The nominal model.
        sample_time: Time between two samples [s].
        samples: Samples of a window, a multiple of those of a block.

    Attributes:
        noise: Standard deviation of the encoders, rounding included [rad or m], shape (M,).
        gain: Gain of the observer model, the same in every pose, shape (2 n, M).
        block: Samples of a block.
        made: Number of designs computed.
        home: Cell of the home pose.

    Raises:
        InputError: The robot states no encoder noise.
    """

    def __init__(self, model: RobotWithEffects, sample_time: float, samples: int) -> None:
        self._sample_time = sample_time
        self._poses = PoseModel(model.robot, sample_time)
        self.noise = known_noise(model)
        self._matters = np.array(self._poses.matters())
        self._home = self._poses.home
        self.gain = motorwise_gain(self._poses.at(self._home), self.noise, sample_time)
        wanted = max(round(BLOCK / sample_time), 1)
        self.block = max(count for count in range(1, wanted + 1) if samples % count == 0)
        self._kept: dict[tuple[int, ...], PoseDesign] = {}
        self.made = 0
        self.home = self.cell(self._home)

    def situations(self) -> list[LinearPose]:
        """Return the home pose, and the same with loaded gears where load changes their stiffness."""
        return [self.at(self.home).design.pose, *self._poses.loaded()]

    def cell(self, position: FloatArray) -> tuple[int, ...]:
        """Return the cell of poses that contains motor positions [rad or m], shape (M,)."""
        steps = np.rint((position - self._home) / PITCH).astype(int)
        return tuple(np.where(self._matters, steps, 0).tolist())

    def at(self, cell: tuple[int, ...]) -> PoseDesign:
        """Return the design of a cell."""
        if (entry := self._kept.pop(cell, None)) is None:
            pose = self._poses.at(self._home + PITCH * np.array(cell))
            new = design(pose, self.noise, self._sample_time, self.gain)
            entry = PoseDesign(new, new.filter.lifted(self.block))
            self.made += 1
            while len(self._kept) >= MOST:
                del self._kept[next(iter(self._kept))]
        self._kept[cell] = entry  # the most recently used one is last
        return entry


def known_noise(model: RobotWithEffects) -> FloatArray:
    """Return the noise that the model states for its encoders [rad or m], shape (M,).

    Known quantisation counts with its largest error, half a step: it is not white while a motor is slow.

    Raises:
        InputError: The model states no noise.
    """
    noise = np.array(model.robot.encoder_noise, dtype=float)
    for law in model.laws:
        if law.effect.as_noise:
            noise[law.motor] = np.hypot(noise[law.motor], law.effect.noise)
    if not np.all(noise > 0):
        raise InputError(
            f"robot {model.robot.name} states encoder noise of {noise.tolist()} rad or m, but it must be above zero "
            "to distinguish errors from noise; give sensors.encoder_noise in the robot file"
        )
    return noise
