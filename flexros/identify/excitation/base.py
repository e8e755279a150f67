"""Base class of excitations: a speed reference and its exact integral."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from flexros.config.per_motor import NotNegativePerMotor, per_motor
from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.random_streams import Stream, generator

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.excitation.lines import Lines


@dataclass(frozen=True, eq=False)
class BlockSignals:
    """The excitation of one block, one record per experiment.

    Attributes:
        speed: Speed reference [rad/s or m/s], shape (n_experiments, n_samples, M).
        position: Its exact integral [rad or m], same shape.
    """

    speed: FloatArray
    position: FloatArray


class AbstractExcitation(Settings, ABC):
    """A speed reference per motor and experiment; its fields are the keys of `identification.excitation`.

    How to add one: write a final subclass with `kind`, its fields and the methods below, and add it to `Excitation`.
    All samples follow from settings, sample time and seed alone, and the position is the exact integral of the speed.
    """

    periodic: ClassVar[bool]
    """Whether records join to a periodic signal; false: every record is at rest before and after."""

    amplitude: NotNegativePerMotor = Field(
        default=0.02,
        description="size of the speed reference, one or one per motor: rms for multisine and burst, peak for chirp "
        "[rad/s or m/s]",
    )
    orthogonal: bool = Field(
        default=True,
        description="whether the experiments of a block differ only by the phases exp(2 pi j (i-1)(l-1)/n); false: "
        "by independent random phases [true/false]",
    )

    def sizes(self, n_motors: int) -> FloatArray:
        """Return the amplitude of every motor [rad/s or m/s], shape (M,)."""
        return per_motor("identification.excitation.amplitude", self.amplitude, n_motors)

    @abstractmethod
    def record_samples(self, sample_time: float) -> int:
        """Return the length of a record, the period of a periodic excitation [samples].

        Args:
            sample_time: Time between two samples [s].

        Raises:
            InputError: The length is not a whole number of samples, or a frequency is above half the sampling rate.
        """

    @abstractmethod
    def lines(self, sample_time: float, seed: int) -> Lines:
        """Return the excited and the detection lines, multiples of one over the record length.

        Args:
            sample_time: Time between two samples [s].
            seed: Seed of the choice of detection lines.
        """

    @abstractmethod
    def block(self, n_motors: int, sample_time: float, seed: int, position: int, block: int) -> BlockSignals:
        """Compute the signals of one block, with new random phases for every position and block.

        Args:
            n_motors: Number of motors M, also that of experiments in a block.
            sample_time: Time between two samples [s].
            seed: Seed of the phases.
            position: Index of the position.
            block: Index of the block in that position.
        """


def phase_generator(seed: int, *path: int) -> np.random.Generator:
    """Return the random generator of phases, independent of those of sensor noise and disturbances.

    Args:
        seed: Seed of the excitation.
        path: Indices of position and block.
    """
    return generator(seed, Stream.EXCITATION, *path)


def shifts(n_motors: int) -> FloatArray:
    """Return the phases of the orthogonal matrix T (Moberg 2007, Paper A, section 4), T T^H = n I.

    Args:
        n_motors: Number of motors and experiments n.

    Returns:
        2 pi (i - 1)(l - 1) / n of motor i in experiment l [rad], shape (n, n), reduced to one turn.
    """
    numbers = np.arange(n_motors)
    return 2.0 * np.pi * (np.outer(numbers, numbers) % n_motors) / n_motors


def whole_samples(name: str, time: float, sample_time: float, least: int = 1) -> int:
    """Convert a time to samples.

    Args:
        name: Key of the time, for the message.
        time: The time [s].
        sample_time: Time between two samples [s].
        least: Smallest allowed number of samples.

    Raises:
        InputError: The time is not a whole number of samples, or too short.
    """
    number = round(time / sample_time)
    if number < least or abs(time / sample_time - number) > 1e-6 * number:
        below = max(int(time / sample_time), least) * sample_time
        raise InputError(
            f"excitation.{name} is {time:g} s, allowed is a whole number of samples of {sample_time:g} s, {least} "
            f"or more; set it e.g. to {below:.9g}"
        )
    return number


def require_below_nyquist(name: str, frequency: float, sample_time: float) -> None:
    """Reject a frequency of half the sampling rate or more.

    Args:
        name: Key of the frequency, for the message.
        frequency: The frequency [Hz].
        sample_time: Time between two samples [s].
    """
    if frequency * sample_time >= 0.5:
        raise InputError(
            f"excitation.{name} is {frequency:g} Hz, allowed is less than half the sampling rate, "
            f"{0.5 / sample_time:g} Hz; lower the frequency or the sample time"
        )
