"""Frequency response of a motor: of the log, the nominal and the repaired robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.signal import csd

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture
from flexros.robot.bode import frequency_response
from flexros.robot.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.signatures.evidence import Evidence


LOWEST = 1.0
"""Lowest frequency shown [Hz] (chosen)."""
PART = 2.0
"""Length of the parts over which spectra of the log are averaged [s] (chosen)."""
LEAST_COHERENCE = 0.9
"""Coherence that the log needs at a frequency to be shown (chosen)."""
POINTS = 600
"""Frequencies of the models (chosen)."""


class FrequencyResponsePicture(AbstractSignature):
    """Acceleration of a motor per its torque, before and after."""

    name: ClassVar[str] = "frequency_response"
    effects: ClassVar[tuple[str, ...]] = (
        "stiffness_error",
        "damping_error",
        "payload_error",
        "motor_inertia_error",
        "torque_gain_error",
        "extra_mode",
        "viscous_friction",
        "nonlinear_stiffness",
    )
    rank: ClassVar[int] = 2

    def picture(self, evidence: Evidence, location: str) -> Picture | None:
        """Compute the responses of the linearised robots, and that of the log where it is coherent."""
        motor = evidence.motor_of(location)
        torque_unit, unit = evidence.units(motor)
        highest = min(250.0, 0.4 / evidence.record.sample_time)
        frequency = np.geomspace(LOWEST, highest, POINTS)
        series = {"log": Curve(*_of_log(evidence, motor, highest), style="points")}
        for name, robot in (("before", evidence.robot), ("after", evidence.repaired)):
            if robot is not None:
                response = frequency_response(linear_model(robot), frequency)[:, motor, motor]
                series[name] = Curve(frequency, (2 * np.pi * frequency) ** 2 * np.abs(response))
        if not len(series["log"].x):
            del series["log"]
        return Picture(
            title=f"Frequency response, {evidence.robot.joint_names[motor]}",
            x_label="frequency [Hz]",
            y_label=f"acceleration per torque [{unit}/s²/{torque_unit}]",
            series=series,
            reading="Valleys and peaks that move sideways are stiffness or inertia, rounder or sharper ones damping, "
            "another level of the ends inertia or gain, a pair more is another mode. Of the log, which moves and is in "
            "closed loop, the response is an approximation.",
            log_x=True,
            log_y=True,
        )


def _of_log(evidence: Evidence, motor: int, highest: float) -> tuple[FloatArray, FloatArray]:
    """Estimate the response of all motors to all torques from averaged spectra, and return that of one to its own."""
    record, rows = evidence.record, evidence.rows
    T, length = record.sample_time, round(PART / record.sample_time)
    m = record.torque.shape[1]
    if len(rows) < 3 * length or not record.valid.all():
        return np.zeros(0), np.zeros(0)
    u = record.torque[rows].T
    # differences, so that slow motion does not leak into the band; divided out again below
    y = np.gradient(np.gradient(record.position[rows], axis=0), axis=0).T
    frequency, S_uu = csd(u[:, None], u[None], 1 / T, nperseg=length)
    _, S_uy = csd(u, np.broadcast_to(y[motor], u.shape), 1 / T, nperseg=length)
    _, S_yy = csd(y[motor], y[motor], 1 / T, nperseg=length)
    band = np.flatnonzero((frequency >= LOWEST) & (frequency <= highest))
    matrix = np.moveaxis(S_uu, 2, 0)[band] + 1e-12 * np.trace(S_uu[:, :, band].mean(axis=2)).real * np.eye(m)
    gains = np.linalg.solve(matrix, S_uy.T[band][:, :, None])[:, :, 0]
    explained = np.einsum("fi,fi->f", gains, S_uy.T[band].conj()).real / np.maximum(S_yy[band].real, 1e-300)
    double = np.sin(2 * np.pi * frequency[band] * T) ** 2
    scale = (2 * np.pi * frequency[band]) ** 2 / double
    good = explained > LEAST_COHERENCE
    return frequency[band][good], (scale * np.abs(gains[:, motor]))[good]
