"""Location of a disturbance torque: at a motor, within a gear, on the arm behind it, or at the tool.

The part of the robot between torque and encoders depends on the location. The spectrum of the innovations is compared
with the response of each location to a torque of unknown size that is white, a random walk or smoother (Whittle 1953:
independent frequencies, each with the noise of the encoders as floor). The location with the greatest likelihood is
reported, and every other one close to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.monitor.design import Design
    from flexros.robot import Robot

Kind = Literal["motor", "gear", "arm", "tool"]

HIGHEST = 250.0
"""Highest frequency that is used [Hz] (chosen)."""
LOWEST_BIN = 3
"""First line of the spectrum that is used; lower ones contain transients from before (chosen)."""
SMOOTHNESS = (0, 1, 2)
"""Number of integrations of white noise that make up a torque [1] (chosen)."""
SIZES = 10.0 ** np.arange(-8.0, 13.0)
"""Variances of a torque that are tried, over the one that equals the noise at the median line [1] (chosen)."""
CLOSE, SURELY, CLOSE_SHARE = 3.0, 2.0, 0.02
"""A location is excluded if its log-likelihood is below the greatest one by the first value, and by the second one in
standard deviations of the difference over the lines (Vuong 1989) or by the third one as a share (chosen)."""
FREEDOM = 0.02
"""Share of its gain by which a location with several components must lead: a force in two directions can imitate two
motors (tuned on development seeds)."""


@dataclass(frozen=True, eq=False)
class DisturbanceLocation:
    """A location of a disturbance torque.

    Attributes:
        kind: At the motor, between motor and arm, on the arm behind the gear, or at the tool.
        joint: Name of the motor; "tool" for the tool.
        force: Generalised forces of the torque, shape (n, components).
    """

    kind: Kind
    joint: str
    force: FloatArray

    @property
    def words(self) -> str:
        """Name of the location."""
        names = {"motor": "at {}", "gear": "in the gear of {}", "arm": "on the arm side of {}", "tool": "at the tool"}
        return names[self.kind].format(self.joint)


@dataclass(frozen=True, eq=False)
class LocationGain:
    """Evidence that the disturbance torque acts at a location.

    Attributes:
        location: The location.
        gain: Gain in log-likelihood over no torque, less the penalty of several components [nats].
        lines: Contribution of every line of the spectrum [nats], shape (lines,).
    """

    location: DisturbanceLocation
    gain: float
    lines: FloatArray


def locations_of(robot: Robot, design: Design) -> tuple[DisturbanceLocation, ...]:
    """List the locations of disturbance torques of a robot.

    Args:
        robot: The robot.
        design: Design at its pose.
    """
    pose, n = design.pose, len(design.pose.mass)
    locations: list[DisturbanceLocation] = []
    for motor, name in enumerate(robot.joint_names):
        locations.append(DisturbanceLocation("motor", name, pose.motor[:, [motor]]))
        coordinate = robot.motor_rows[motor]
        arm = robot.gear_rows[motor]
        spring = pose.stiffness[:, [coordinate]]
        if coordinate != arm and spring[coordinate, 0] > 0:
            locations.append(DisturbanceLocation("gear", name, spring / spring[coordinate, 0]))
            locations.append(DisturbanceLocation("arm", name, np.eye(n)[:, [arm]]))
    seen = np.flatnonzero(np.abs(pose.tool).max(axis=0) > 1e-9)
    if len(seen):
        locations.append(DisturbanceLocation("tool", "tool", pose.tool[:, seen]))
    return tuple(locations)


def ranked_locations(
    innovations: FloatArray,
    design: Design,
    locations: Sequence[DisturbanceLocation],
    noise: FloatArray,
    sample_time: float,
) -> tuple[LocationGain, ...]:
    """Rank locations by their likelihood.

    Args:
        innovations: Innovations of the last seconds [rad or m], shape (samples, M).
        design: Design that produced them.
        locations: Locations to compare.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        sample_time: Time between two samples [s].

    Returns:
        The locations, the most likely first.
    """
    samples = len(innovations)
    last = min(int(HIGHEST * samples * sample_time), samples // 2)
    lines = np.arange(LOWEST_BIN, max(last, LOWEST_BIN + 1))
    taper = np.hanning(samples)
    spectrum = np.fft.rfft(innovations * (taper / np.linalg.norm(taper))[:, None], axis=0)[lines]
    z = np.exp(2j * np.pi * lines / samples)
    white, response = _whitened(spectrum, design, locations, noise, z)
    ends = np.cumsum([location.force.shape[1] for location in locations])
    parts = np.split(response, ends[:-1], axis=2)
    gains = [_gain(white, part, z) for part in parts]
    ranked = [_with_penalty(location, lines) for location, lines in zip(locations, gains)]
    return tuple(sorted(ranked, key=lambda entry: -entry.gain))


def close(ranked: Sequence[LocationGain]) -> tuple[LocationGain, ...]:
    """Keep the most likely location and those close to it."""

    def is_close(other: LocationGain) -> bool:
        apart = ranked[0].lines - other.lines
        scatter = SURELY * float(np.linalg.norm(apart - apart.mean()))
        return float(apart.sum()) < max(CLOSE, min(scatter, CLOSE_SHARE * ranked[0].gain))

    return tuple(other for other in ranked if is_close(other))


def _with_penalty(location: DisturbanceLocation, lines: FloatArray) -> LocationGain:
    kept = lines * (1 - FREEDOM) if location.force.shape[1] > 1 else lines
    return LocationGain(location, float(kept.sum()), kept)


def _whitened(
    spectrum: ComplexArray, design: Design, locations: Sequence[DisturbanceLocation], noise: FloatArray, z: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Whiten the spectrum, shape (lines, M), and the responses to the locations, shape (lines, M, columns)."""
    filter_, M, s = design.filter, len(noise), len(design.gain)
    seen = -filter_.C[:M]
    forces = np.hstack([location.force for location in locations])
    pushed = np.zeros((len(filter_.A), forces.shape[1]))
    pushed[:s] = design.pose.push @ forces
    fed = filter_.B.copy()
    fed[:s] += design.pose.transition @ design.gain
    inner = z[:, None, None] * np.eye(len(filter_.A)) - filter_.A
    through = np.linalg.solve(inner, np.hstack([fed, pushed]).astype(complex))
    out = seen @ through
    whitening = np.linalg.inv((np.eye(M) - out[:, :, :M]) * noise)
    white, responses = np.einsum("lij,lj->li", whitening, spectrum), whitening @ out[:, :, M:]
    return np.asarray(white, dtype=complex), np.asarray(responses, dtype=complex)


def _gain(white: ComplexArray, response: ComplexArray, z: ComplexArray) -> FloatArray:
    """Return by line the greatest gain in log-likelihood of a torque whose components share one variance."""
    norm = np.sqrt(np.mean(np.abs(response) ** 2, axis=(0, 1)))
    response = response / np.where(norm > 0, norm, 1.0)
    seen = np.einsum("lij,li->lj", response.conj(), white)
    inner = response.conj().transpose(0, 2, 1) @ response
    values, vectors = np.linalg.eigh(inner)
    values = np.clip(values, 0.0, None)
    power = np.abs(np.einsum("lij,li->lj", vectors.conj(), seen)) ** 2
    best = np.zeros(len(z))
    for order in SMOOTHNESS:
        shape = np.abs(1 - 1 / z) ** (-2.0 * order)
        scale = 1 / max(float(np.median(values.max(axis=1) * shape)), 1e-300)
        for size in SIZES:
            variance = (size * scale * shape)[:, None]
            grown = 1 + variance * values
            gain = np.sum(variance * power / grown - np.log(grown), axis=1)
            best = gain if gain.sum() > best.sum() else best
    return best
