"""The key `slow_motion`: what runs under the excitation so that the motors do not rest or turn back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from pydantic import Field

from flexros.config.per_motor import NotNegativePerMotor, per_motor
from flexros.config.settings import Settings

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class NoSlowMotion(Settings):
    """The excitation alone."""

    kind: Literal["none"] = Field(default="none", description="kind of slow motion [name]")


class ConstantSpeed(Settings):
    """Constant speed, forwards in one experiment and backwards in the next, so that the robot stays near its position.

    A motor that never stops has no Coulomb friction but a constant one, which a frequency response does not see
    (Moberg 2007, Paper A, section 2, after Wernholt and Gunnarsson).
    """

    kind: Literal["constant_speed"] = Field(description="kind of slow motion [name]")
    speed: NotNegativePerMotor = Field(description="speed, one or one per motor [rad/s or m/s]")
    allow_reversal: bool = Field(
        default=False, description="whether motors may turn back where the excitation moves them faster [true/false]"
    )

    def speeds(self, n_motors: int) -> FloatArray:
        """Return the speed of every motor [rad/s or m/s], shape (M,)."""
        return per_motor("identification.slow_motion.speed", self.speed, n_motors)


class SlowSine(Settings):
    """A sine with whole cycles in the period of the excitation, which passes zero speed twice in a cycle only."""

    kind: Literal["sine"] = Field(description="kind of slow motion [name]")
    speed: NotNegativePerMotor = Field(description="amplitude of the speed, one or one per motor [rad/s or m/s]")
    cycles: int = Field(
        default=1,
        ge=1,
        description="whole cycles in a period, a line without excitation; an odd number keeps even lines quiet [1]",
    )

    def speeds(self, n_motors: int) -> FloatArray:
        """Return the speed of every motor [rad/s or m/s], shape (M,)."""
        return per_motor("identification.slow_motion.speed", self.speed, n_motors)


SlowMotion: TypeAlias = Annotated[NoSlowMotion | ConstantSpeed | SlowSine, Field(discriminator="kind")]
"""Any slow motion, distinguished by its key `kind`."""
