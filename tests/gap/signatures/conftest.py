"""Signature data of logs with one effect each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.signatures.signature_data import SignatureData
from flexros.robot import load_robot
from tests.oracles.linear_gap import LinearLog, Torque, linear_log, nothing


def swing(n: int, sample_time: float, amplitude: float, hertz: float) -> FloatArray:
    """Let the motor swing, with some faster motion on top."""
    time = sample_time * np.arange(n)[:, None]
    shape = (
        np.sin(2 * np.pi * hertz * time) + 0.02 * np.sin(2 * np.pi * 7.3 * time) + 0.01 * np.sin(2 * np.pi * 19 * time)
    )
    return np.asarray(np.minimum(time, 1.0) * amplitude * shape)


def axis(disturbance: Torque) -> LinearLog:
    robot = load_robot("four_mass_linear")
    return linear_log(robot, swing(16000, robot.sample_time, 12.0, 0.4), (10.0, 0.8), disturbance)


def signature_data_of(log: LinearLog, repaired: LinearLog) -> SignatureData:
    return SignatureData(log.robot, log.record, log.observer, log.prediction, repaired.prediction, log.robot)


@pytest.fixture(scope="session")
def no_gap() -> LinearLog:
    return axis(nothing)


@pytest.fixture(scope="session")
def friction(no_gap: LinearLog) -> SignatureData:
    """Coulomb friction of 0.3 Nm."""

    def torque(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, position, command
        return np.asarray(-0.3 * np.tanh(speed / 0.05))

    return signature_data_of(axis(torque), no_gap)


@pytest.fixture(scope="session")
def ripple(no_gap: LinearLog) -> SignatureData:
    """Cogging of order 6 and 0.1 Nm."""

    def torque(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, speed, command
        return np.asarray(0.1 * np.sin(6 * position))

    return signature_data_of(axis(torque), no_gap)


@pytest.fixture(scope="session")
def late(no_gap: LinearLog) -> SignatureData:
    """Commands that act two samples late."""
    line = [np.zeros(1)] * 2

    def torque(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, position, speed
        line.append(command)
        return np.asarray(line.pop(0) - command)

    return signature_data_of(axis(torque), no_gap)


@pytest.fixture(scope="session")
def weak(no_gap: LinearLog) -> SignatureData:
    """Torques that are 10 % too small."""

    def torque(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, position, speed
        return np.asarray(-0.1 * command)

    return signature_data_of(axis(torque), no_gap)


def with_gear(part: Callable[[float], float], no_gap: LinearLog) -> SignatureData:
    """Let the gear transmit k_1 times a part of its torsion."""
    robot = load_robot("four_mass_linear")
    time = robot.sample_time * np.arange(16000)
    shaken = (
        0.25 * np.sin(np.pi * time / 8) * sum(np.sin(2 * np.pi * hertz * time + hertz) for hertz in (2.3, 4.1, 7.7))
    )
    log = linear_log(robot, shaken[:, None], (10.0, 0.8), gear=lambda torsion: 100.0 * (part(torsion) - torsion))
    return signature_data_of(log, no_gap)


@pytest.fixture(scope="session")
def softer_gear(no_gap: LinearLog) -> SignatureData:
    """A gear of 80 Nm/rad instead of 100."""
    return with_gear(lambda torsion: 0.8 * torsion, no_gap)


@pytest.fixture(scope="session")
def loose_gear(no_gap: LinearLog) -> SignatureData:
    """A gear with a gap of 0.01 rad."""
    return with_gear(lambda torsion: torsion - min(max(torsion, -0.005), 0.005), no_gap)
