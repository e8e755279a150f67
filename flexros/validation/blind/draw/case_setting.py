"""Setting of a case: robot, sampling rate, controller and kind of references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros.validation.blind.draw.case_robots import case_robot, robot_source
from flexros.validation.blind.draw.controllers import feedforward, random_controller
from flexros.validation.blind.draw.references import random_reference, room_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot

RATES = (2, 2, 2, 2, 2, 2, 2, 2, 1, 4)
"""Sampling rates [kHz] among which one is drawn."""
MANY_MOTORS, MANY_MOTORS_RATES = 5, (0.25, 0.5)
"""Number of motors from which a robot is an arm, and sampling rates of the recorders of arms [kHz] (chosen)."""
DIAGNOSIS_SHARE = 0.6
"""Share of cases that move as `flexros run diagnosis` does; the others move at random (chosen)."""


@dataclass(frozen=True, eq=False)
class Setting:
    """Setting of a case.

    Attributes:
        robot: The true robot.
        sample_time: Time between two samples [s].
        law: Control law.
        motion: "diagnosis" or "random".
        full: Whether the feedforward accelerates; else it only holds the start.
    """

    robot: Robot
    sample_time: float
    law: AbstractControlLaw
    motion: str
    full: bool

    @classmethod
    def draw(cls, name: str, random: np.random.Generator) -> Setting:
        """Draw how a robot is run.

        Args:
            name: Name of the robot.
            random: Random numbers.
        """
        robot = case_robot(name)
        rates = RATES if robot.n_motors < MANY_MOTORS else MANY_MOTORS_RATES
        sample_time = 1e-3 / float(random.choice(rates))
        law = random_controller(robot, sample_time, random)
        motion = "diagnosis" if random.uniform() < DIAGNOSIS_SHARE else "random"
        return cls(robot, sample_time, law, motion, bool(random.uniform() < 0.6))

    def reference(self, duration: float, random: np.random.Generator, motion: str = "") -> FloatArray:
        """Draw a reference: motor positions, speeds and feedforward torques, shape (n, 3 M).

        Args:
            duration: Its length [s].
            random: Random numbers.
            motion: Another motion than that of the case.
        """
        if (motion or self.motion) == "diagnosis":
            return self._diagnosis(duration, int(random.integers(2**31)))
        position = random_reference(room_of(self.robot), duration, self.sample_time, random)
        torque = feedforward(self.robot, position, self.sample_time, self.full)
        return np.hstack([position, np.gradient(position, self.sample_time, axis=0), torque])

    def _diagnosis(self, duration: float, seed: int) -> FloatArray:
        scenario = load_scenario("diagnosis")
        assert scenario.diagnosis is not None
        changed = scenario.model_copy(
            update={
                "robot": robot_source(self.robot.name),
                "seed": seed,
                "sample_time": self.sample_time,
                "diagnosis": scenario.diagnosis.model_copy(update={"length": duration, "seed": seed}),
            }
        )
        wanted = Experiment.prepare(changed).reference
        torque = wanted.torque
        if not self.full:
            torque = feedforward(self.robot, wanted.motor_position, self.sample_time, full=False)
        return np.hstack([wanted.motor_position, wanted.motor_velocity, torque])
