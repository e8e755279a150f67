"""Frequency response of a motor: of the log, the nominal and the repaired robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.signal import csd

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture
from flexros.robot.linear.bode import frequency_response
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.gap.signatures.signature_data import SignatureData


LOWEST = 1.0
"""Lowest frequency shown [Hz] (chosen)."""
PART = 2.0
"""Length of the parts over which spectra of the log are averaged [s] (chosen)."""
LEAST_COHERENCE = 0.9
"""Smallest coherence of the log at which its response is shown (chosen)."""
SMALLEST = 1e-9
"""Singular value of spectra, over the largest, that counts as zero [1] (chosen)."""
POINTS = 600
"""Number of frequencies of the models (chosen)."""


class FrequencyResponsePicture(AbstractSignature):
    """Acceleration of a motor per its torque, before and after."""

    name: ClassVar[str] = "frequency_response"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Compute the responses of the linearised robots, and that of the log where it is coherent."""
        motor = data.motor_of(location)
        torque_unit, unit = data.units(motor)
        highest = min(250.0, 0.4 / data.record.sample_time)
        frequency = np.geomspace(LOWEST, highest, POINTS)
        series = {"log": Curve(*_of_log(data, motor, highest), style="points")}
        for name, robot in (("before", data.robot), ("after", data.repaired)):
            if robot is not None:
                response = frequency_response(linear_model(robot), frequency)[:, motor, motor]
                series[name] = Curve(frequency, (2 * np.pi * frequency) ** 2 * np.abs(response))
        return Picture(
            title=f"Frequency response, {data.robot.joint_names[motor]}",
            x_label="frequency [Hz]",
            y_label=f"acceleration per torque [{unit}/s²/{torque_unit}]",
            series=series,
            reading="Antiresonances and resonances at other frequencies show an error of stiffness or inertia, "
            "wider or narrower ones of damping, another level at the ends of inertia or gain. An additional pair is an "
            "additional mode. The response of the log is an approximation: the robot moves, in closed loop.",
            log_x=True,
            log_y=True,
        )


def _of_log(data: SignatureData, motor: int, highest: float) -> tuple[FloatArray, FloatArray]:
    """Estimate the response of all motors to all torques from averaged spectra, and return that of one to its own.

    The recorded reference is the instrumental variable, so that noise in the loop does not bias the estimate.
    """
    record, rows = data.record, data.rows
    T, length = record.sample_time, round(PART / record.sample_time)
    parts = len(rows) // (length // 2) - 1  # they overlap by half
    if parts < max(5, 2 * len(record.torque[0])) or not record.valid.all():
        return np.zeros(0), np.zeros(0)  # as many parts as motors are coherent whatever they show
    # second differences, so that slow motion does not leak into the band; their gain is divided out below
    u = record.torque[rows].T
    y = _differenced(record.position[rows])
    r = u if record.reference is None else _differenced(record.reference[rows])
    frequency, S_rr = _spectra(r, r, T, length)
    _, S_ru = _spectra(r, u, T, length)
    _, S_ry = _spectra(r, y[motor : motor + 1], T, length)
    _, S_yy = _spectra(y[motor : motor + 1], y[motor : motor + 1], T, length)
    band = np.flatnonzero((frequency >= LOWEST) & (frequency <= highest))
    floor = 1e-9 * np.trace(S_rr[band].mean(axis=0)).real * np.eye(len(r))
    known = np.linalg.pinv(S_rr[band] + floor, rcond=SMALLEST, hermitian=True) @ S_ry[band]
    explained = np.einsum("fi,fi->f", known[:, :, 0], S_ry[band][:, :, 0].conj()).real
    good = explained > LEAST_COHERENCE * S_yy[band][:, 0, 0].real
    if not good.any():
        return np.zeros(0), np.zeros(0)
    # torques that do not vary, or always vary together, have no response of their own
    gains = (np.linalg.pinv(S_ru[band][good], rcond=SMALLEST) @ S_ry[band][good])[:, motor, 0]
    good[good] = gains != 0
    gains, shown = gains[gains != 0], frequency[band][good]
    return shown, (2 * np.pi * shown) ** 2 / np.sin(2 * np.pi * shown * T) ** 2 * np.abs(gains)


def _differenced(values: FloatArray) -> FloatArray:
    """Difference twice over two samples each, which multiplies by -sin(wT)^2; shape (n, k) -> (k, n)."""
    return np.asarray(np.gradient(np.gradient(values, axis=0), axis=0).T)


def _spectra(a: FloatArray, b: FloatArray, sample_time: float, length: int) -> tuple[FloatArray, ComplexArray]:
    """Return frequencies and averaged cross spectra conj(A) B, shape (F, signals of a, signals of b)."""
    frequency, spectrum = csd(a[:, None], b[None], 1 / sample_time, nperseg=length)
    return frequency, np.moveaxis(spectrum, 2, 0)
