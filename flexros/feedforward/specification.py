"""Settings of the feedforward in a scenario or a node parameter file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from flexros.config.per_motor import NotNegativePerMotor, Positive, PositivePerMotor
from flexros.config.settings import Settings


class FrictionCompensation(Settings):
    """Motor friction that the feedforward torque compensates; one value, or one per motor."""

    viscous: NotNegativePerMotor = Field(0.0, description="[Nm s/rad, or N s/m]")
    coulomb: NotNegativePerMotor = Field(0.0, description="level [Nm, or N]")
    stribeck: NotNegativePerMotor = Field(0.0, description="extra level near standstill [Nm, or N]")
    stribeck_velocity: PositivePerMotor = Field(
        0.1, description="motor speed at which the extra level has fallen to 1/e [rad/s, or m/s]"
    )
    smoothing_velocity: PositivePerMotor = Field(
        0.01, description="motor speed at which the smoothed sign reaches tanh(1) = 0.76 [rad/s, or m/s]"
    )


class FeedforwardSpecification(Settings):
    """Method that computes motor references and torques from the desired output."""

    method: Literal["none", "rigid", "flexible_joint", "dae", "stable_inversion"] = Field(
        "dae",
        description="none (feedback alone), rigid, flexible_joint (Moberg 2007, eq. 5.5), dae (Paper B) or "
        "stable_inversion (bounded inverse where the zero dynamics are unstable, with motion before that of the tool)",
    )
    non_minimum_phase: Literal["stable_inversion", "refuse"] = Field(
        "stable_inversion",
        description="what dae does where the zero dynamics are unstable: stable inversion, or a refusal",
    )
    order: Literal[1, 2] = Field(
        2, description="order of the DAE method: 1 = backward Euler as published, 2 = second order; dae only"
    )
    output: str | None = Field(None, description="controlled output of the robot; default: that of its file")
    friction: FrictionCompensation | None = Field(None, description="friction added to the motor torque; default: none")
    stiffness: dict[str, Positive] = Field(
        default_factory=dict,
        description="gear stiffness by motor name [Nm/rad, or N/m] instead of the equivalent one; flexible_joint only",
    )
    hold_compensation: bool | None = Field(
        None,
        description="torque as the mean over the time in which it acts, delay included, instead of its value at the "
        "instant; default: true, except for dae of order 1, which is as published",
    )
    zero_dynamics_poses: Annotated[int, Field(ge=1)] = Field(
        5,
        description="number of poses along the path at which the zero dynamics are checked; dae, stable_inversion only",
    )
    compiled: bool = Field(
        True, description="time stepping in machine code; false: in the CasADi virtual machine; dae only"
    )

    @model_validator(mode="after")
    def _settings_in_use(self) -> FeedforwardSpecification:
        if self.stiffness and self.method != "flexible_joint":
            raise ValueError(
                f"stiffness is given for method '{self.method}', but only flexible_joint uses it; remove it or change "
                "the method"
            )
        return self
