"""Input data of the pictures of signatures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.signatures.disturbance_torque import disturbance_torque
from flexros.gap.where.motion import MotorMotion, motion_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class SignatureData:
    """A log with the predictions of the nominal and the repaired model.

    Attributes:
        robot: The nominal robot.
        record: The log.
        observer: Gain of the predictor of the nominal robot.
        before: Prediction of the nominal robot.
        after: Prediction of the repaired robot; None where nothing was repaired.
        repaired: The repaired robot, with the viscous friction of its effects and without their other laws; None where
            nothing was repaired.
        tool_error: Measured minus predicted tool positions [m], shape (n_t, 3), at the times of the record's tool;
            None where the tool was not measured.
    """

    robot: Robot
    record: Record
    observer: ObserverGain
    before: PredictedLog
    after: PredictedLog | None = None
    repaired: Robot | None = None
    tool_error: FloatArray | None = None

    @cached_property
    def motion(self) -> MotorMotion:
        """Speeds, accelerations, rotor angles and gear torques of the log."""
        return motion_of(self.record, self.robot, self.before.states)

    @cached_property
    def disturbance(self) -> FloatArray:
        """Disturbance torques at the motors with the nominal model [Nm or N], shape (n, M)."""
        return disturbance_torque(self.before.innovations, self.record, self.robot, self.observer)

    @cached_property
    def disturbance_after(self) -> FloatArray | None:
        """Disturbance torques with the repaired model; None where nothing was repaired."""
        if self.after is None:
            return None
        return disturbance_torque(self.after.innovations, self.record, self.robot, self.observer)

    @cached_property
    def gear_disturbance(self) -> dict[str, FloatArray]:
        """Torques by which the gears transmit less than their nominal springs and dampers [Nm or N].

        Keys are "before", and "after" where there is a repaired model; shape (n, M) each, without their slow part.
        """
        torques = {}
        for name, prediction in (("before", self.before), ("after", self.after)):
            if prediction is not None:
                errors = prediction.innovations
                torques[name] = disturbance_torque(errors, self.record, self.robot, self.observer, entry="gear")
        return torques

    @cached_property
    def rows(self) -> IntArray:
        """Indices of measured samples without beginning and end, where the estimates have not settled, shape (k,)."""
        n = self.record.n_samples
        first = max(self.before.first, min(self.observer.settling, n // 10))
        inside = np.zeros(n, dtype=bool)
        inside[first : n - min(self.observer.settling, n // 10) // 4] = True
        return np.flatnonzero(inside & self.record.valid)

    def units(self, motor: int) -> tuple[str, str]:
        """Return the units of a motor's torque and position: "Nm" and "rad", or "N" and "m"."""
        return self.robot.motors[motor].torque_unit, self.robot.motors[motor].position_unit

    def motor_disturbance(self, motor: int) -> dict[str, FloatArray]:
        """Return the disturbance torques at a motor, at the samples `rows`.

        Returns:
            Torques [Nm or N] "before", and "after" where there is a repaired model, shape (k,).
        """
        torques = {"before": self.disturbance[self.rows, motor]}
        if self.disturbance_after is not None:
            torques["after"] = self.disturbance_after[self.rows, motor]
        return torques

    def motor_of(self, location: str) -> int:
        """Return the index of the motor that a location belongs to.

        Args:
            location: A joint, spring, body, "tool", "base" or "all"; a location that belongs to no joint is assigned to
                the motor with the largest prediction errors.
        """
        names = self.robot.joint_names
        if location in names:
            return names.index(location)
        if location in self.robot.arm_names:
            arm = self.robot.arm_names.index(location)
            before = [motor for motor, row in enumerate(self.robot.gear_rows) if row <= arm]
            return before[-1] if before else 0
        excess = (self.before.innovations / self.before.sd)[self.record.valid]
        return int((excess**2).mean(axis=0).argmax())
