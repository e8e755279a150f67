"""Where a missing torque acts: at a motor, within a gear, behind it on the arm, or at the tool.

A torque that acts elsewhere reaches the encoders through another part of the robot. The spectrum of the sudden part of
the errors is compared with what each place would make of a torque of unknown size, white, walking at random or smoother
(Whittle 1953: independent frequencies, each with the noise of the encoders as floor). The place with the greatest
likelihood is told, and every other one that comes close.
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
"""Highest frequency that is looked at [Hz] (chosen)."""
LOWEST_BIN = 3
"""First line of the spectrum that is looked at; those below hold what began before (chosen)."""
SMOOTHNESS = (0, 1, 2)
"""How often a torque is the sum of white noise [1] (chosen)."""
SIZES = 10.0 ** np.arange(-8.0, 13.0)
"""Variances of a torque that are tried, over that at which it equals the noise at the median line [1] (chosen)."""
CLOSE, SURELY, CLOSE_SHARE = 3.0, 2.0, 0.02
"""A place is left out when it is behind the likeliest one by this log-likelihood, and by either so many standard
deviations of the difference as it scatters from line to line (Vuong 1989) or this share of the whole (chosen)."""
FREEDOM = 0.02
"""Share of its gain by which a place with several components must be ahead: a force in two directions can imitate two
motors (development seeds)."""


@dataclass(frozen=True, eq=False)
class DisturbanceLocation:
    """A place where a torque may act.

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
        """The place in words."""
        told = {"motor": "at {}", "gear": "in the gear of {}", "arm": "on the arm side of {}", "tool": "at the tool"}
        return told[self.kind].format(self.joint)


@dataclass(frozen=True, eq=False)
class Suspicion:
    """How likely it is that the missing torque acts at a place.

    Attributes:
        place: The place.
        gain: Gain in log-likelihood over no torque, less the price of several components [nats].
        lines: What every line of the spectrum adds to it [nats], shape (lines,).
    """

    place: DisturbanceLocation
    gain: float
    lines: FloatArray


def places_of(robot: Robot, found: Design) -> tuple[DisturbanceLocation, ...]:
    """List the places of a robot.

    Args:
        robot: The robot.
        found: Design at its pose.
    """
    pose, n = found.pose, len(found.pose.mass)
    places: list[DisturbanceLocation] = []
    for motor, name in enumerate(robot.joint_names):
        places.append(DisturbanceLocation("motor", name, pose.motor[:, [motor]]))
        coordinate = robot.motor_rows[motor]
        arm = robot.gear_rows[motor]
        spring = pose.stiffness[:, [coordinate]]
        if coordinate != arm and spring[coordinate, 0] > 0:
            places.append(DisturbanceLocation("gear", name, spring / spring[coordinate, 0]))
            places.append(DisturbanceLocation("arm", name, np.eye(n)[:, [arm]]))
    seen = np.flatnonzero(np.abs(pose.tool).max(axis=0) > 1e-9)
    if len(seen):
        places.append(DisturbanceLocation("tool", "tool", pose.tool[:, seen]))
    return tuple(places)


def suspicions(
    sudden: FloatArray, found: Design, places: Sequence[DisturbanceLocation], noise: FloatArray, sample_time: float
) -> tuple[Suspicion, ...]:
    """Compare places.

    Args:
        sudden: Sudden part of the errors, the last seconds of it [rad or m], shape (samples, M).
        found: The design that made it.
        places: Places to be compared.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        sample_time: Time between two samples [s].

    Returns:
        The places, the likeliest first.
    """
    samples = len(sudden)
    last = min(int(HIGHEST * samples * sample_time), samples // 2)
    lines = np.arange(LOWEST_BIN, max(last, LOWEST_BIN + 1))
    taper = np.hanning(samples)
    spectrum = np.fft.rfft(sudden * (taper / np.linalg.norm(taper))[:, None], axis=0)[lines]
    z = np.exp(2j * np.pi * lines / samples)
    white, response = _whitened(spectrum, found, places, noise, z)
    ends = np.cumsum([place.force.shape[1] for place in places])
    parts = np.split(response, ends[:-1], axis=2)
    gains = [_gain(white, part, z) for part in parts]
    ranked = [_priced(place, lines) for place, lines in zip(places, gains)]
    return tuple(sorted(ranked, key=lambda one: -one.gain))


def close(found: Sequence[Suspicion]) -> tuple[Suspicion, ...]:
    """Keep the likeliest place and those that come close."""

    def comes_close(other: Suspicion) -> bool:
        apart = found[0].lines - other.lines
        scatter = SURELY * float(np.linalg.norm(apart - apart.mean()))
        return float(apart.sum()) < max(CLOSE, min(scatter, CLOSE_SHARE * found[0].gain))

    return tuple(one for one in found if comes_close(one))


def _priced(place: DisturbanceLocation, lines: FloatArray) -> Suspicion:
    kept = lines * (1 - FREEDOM) if place.force.shape[1] > 1 else lines
    return Suspicion(place, float(kept.sum()), kept)


def _whitened(
    spectrum: ComplexArray, found: Design, places: Sequence[DisturbanceLocation], noise: FloatArray, z: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Bring spectrum, shape (lines, M), and responses to the places, shape (lines, M, columns), to white noise."""
    one, M, s = found.filter, len(noise), len(found.gain)
    seen = -one.C[:M]
    forces = np.hstack([place.force for place in places])
    pushed = np.zeros((len(one.A), forces.shape[1]))
    pushed[:s] = found.pose.push @ forces
    fed = one.B.copy()
    fed[:s] += found.pose.transition @ found.gain
    inner = z[:, None, None] * np.eye(len(one.A)) - one.A
    through = np.linalg.solve(inner, np.hstack([fed, pushed]).astype(complex))
    out = seen @ through
    whitening = np.linalg.inv((np.eye(M) - out[:, :, :M]) * noise)
    white, responses = np.einsum("lij,lj->li", whitening, spectrum), whitening @ out[:, :, M:]
    return np.asarray(white, dtype=complex), np.asarray(responses, dtype=complex)


def _gain(white: ComplexArray, response: ComplexArray, z: ComplexArray) -> FloatArray:
    """Give the greatest gain in log-likelihood of a torque whose components have one variance, line by line."""
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
