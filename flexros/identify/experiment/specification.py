"""The key `identification` of a scenario: positions, excitation, periods and moves of an experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from flexros.config.per_motor import PositivePerMotor, per_motor
from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.identify.excitation.burst import Burst
from flexros.identify.excitation.chirp import Chirp
from flexros.identify.excitation.multisine import Multisine
from flexros.identify.experiment.slow_motion import NoSlowMotion, SlowMotion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

Excitation: TypeAlias = Annotated[Multisine | Chirp | Burst, Field(discriminator="kind")]
"""Any excitation, distinguished by its key `kind`."""

Blocks: TypeAlias = Annotated[int, Field(ge=0, le=1000)]
"""Number of blocks in a position; 0 leaves the position out."""


class MoveSettings(Settings):
    """Moves from position to position: all joints at once, with a time law of 9th degree."""

    speed: PositivePerMotor = Field(default=1.0, description="largest speed, one or one per motor [rad/s or m/s]")
    acceleration: PositivePerMotor = Field(
        default=3.0, description="largest acceleration, one or one per motor [rad/s^2 or m/s^2]"
    )


class LimitSettings(Settings):
    """Limits in addition to the torque limits of the robot file; checked on the nominal model before a run."""

    position: tuple[tuple[float, float], ...] | None = Field(
        default=None, description="lowest and highest gear angle of every motor [rad or m]; no limit when left out"
    )
    speed: PositivePerMotor | None = Field(
        default=None, description="largest motor speed, one or one per motor [rad/s or m/s]; no limit when left out"
    )
    torque_share: float = Field(
        default=0.95, gt=0.0, le=1.0, description="share of the torque limits that the prediction may reach [1]"
    )

    @model_validator(mode="after")
    def _ranges_are_not_empty(self) -> LimitSettings:
        for low, high in self.position or ():
            if not low < high:
                raise ValueError(f"the position limits [{low:g}, {high:g}] hold nothing, allowed is low below high")
        return self


class IdentificationSpecification(Settings):
    """An identification experiment: in every position blocks of experiments, each of whole periods.

    In a scenario, for example::

        identification:
          positions: [[0, 0.2, 0.1, 0, 0.6, 0.3], [0.5, 0, 0, 0, 0.4, 0]]
          blocks: 2
          excitation: {kind: multisine, period: 2, lowest: 0.5, highest: 60, amplitude: 0.02}
          slow_motion: {kind: sine, speed: 0.05}

    A block holds one experiment per motor, of which the frequency response matrix follows (Moberg 2007, Paper A,
    section 4). An experiment is: fade in, transient periods, recorded periods, fade out.
    """

    positions: tuple[tuple[float, ...], ...] = Field(
        min_length=1, description="gear angles of every position, one number per motor [rad or m]"
    )
    blocks: Blocks | tuple[Blocks, ...] = Field(
        default=2, description="blocks of experiments, in every position or one number per position [1]"
    )
    excitation: Excitation = Field(
        default_factory=Multisine, description="speed reference that excites the robot: kind multisine, chirp or burst"
    )
    periods: int = Field(default=2, ge=1, le=1000, description="recorded whole periods of every experiment [1]")
    transient_periods: int = Field(
        default=2, ge=0, le=1000, description="whole periods before them, until the response is periodic [1]"
    )
    fade: float = Field(
        default=0.25, gt=0.0, le=60.0, description="time in which a periodic excitation is faded in and out [s]"
    )
    slow_motion: SlowMotion = Field(
        default_factory=NoSlowMotion, description="motion under the excitation: kind none, constant_speed or sine"
    )
    move: MoveSettings = Field(default_factory=MoveSettings, description="speed of the moves between positions")
    settle: float = Field(default=0.5, ge=0.0, le=600.0, description="rest after a move [s]")
    limits: LimitSettings = Field(
        default_factory=LimitSettings, description="limits that are checked on the nominal model before the run"
    )
    seed: int | None = Field(
        default=None,
        ge=0,
        lt=2**63,
        description="seed of random phases and detection lines; that of the scenario when left out [1]",
    )

    @model_validator(mode="after")
    def _goes_together(self) -> IdentificationSpecification:
        if not isinstance(self.blocks, int) and len(self.blocks) != len(self.positions):
            raise ValueError(
                f"there are {len(self.blocks)} numbers of blocks for {len(self.positions)} positions, allowed is one "
                "number for all, or one per position"
            )
        if not any(self.blocks_per_position):
            raise ValueError("no position has a block, allowed is at least one; raise blocks")
        return self

    @property
    def blocks_per_position(self) -> tuple[int, ...]:
        """Number of blocks in every position, length Q."""
        return (self.blocks,) * len(self.positions) if isinstance(self.blocks, int) else self.blocks

    def check_motors(self, n_motors: int) -> None:
        """Refuse settings that are given for another number of motors.

        Args:
            n_motors: Number of motors M of the robot.

        Raises:
            InputError: Names the key.
        """
        self.gears(n_motors)
        self.excitation.sizes(n_motors)
        per_motor("identification.move.speed", self.move.speed, n_motors)
        per_motor("identification.move.acceleration", self.move.acceleration, n_motors)
        if not isinstance(self.slow_motion, NoSlowMotion):
            self.slow_motion.speeds(n_motors)
        if self.limits.speed is not None:
            per_motor("identification.limits.speed", self.limits.speed, n_motors)
        if self.limits.position is not None and len(self.limits.position) != n_motors:
            raise InputError(
                f"identification.limits.position has {len(self.limits.position)} ranges, allowed is one [low, high] "
                f"for each of the {n_motors} motors; correct it"
            )

    def gears(self, n_motors: int) -> FloatArray:
        """Return the positions.

        Args:
            n_motors: Number of motors M of the robot.

        Returns:
            Gear angles [rad or m], shape (Q, M).

        Raises:
            InputError: A position has not one number per motor.
        """
        for number, position in enumerate(self.positions):
            if len(position) != n_motors:
                raise InputError(
                    f"identification.positions[{number}] has {len(position)} gear angles, allowed is one for each of "
                    f"the {n_motors} motors; correct it"
                )
        return np.array(self.positions, dtype=float)
