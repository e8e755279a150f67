"""H-infinity mixed sensitivity."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from flexros.control.design.continuous import ContinuousSystem, delayed_plant, tustin
from flexros.control.design.h_infinity import h_infinity
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem

if TYPE_CHECKING:
    import control


class MixedSensitivity(AbstractDesignMethod):
    """Least H-infinity norm of weighted sensitivity, control sensitivity and complementary sensitivity.

    min over K of gamma = |[W1 S; W2 K S; W3 T]| with
    W1 = (s / peak + bandwidth) / (s + bandwidth least), W2 = 1 / torque, W3 = (s + roll_off / peak) /
    (s / 1000 + roll_off) (Skogestad and Postlethwaite 2005, section 9.3; python-control and SLICOT SB10AD). The poles
    of the design plant are moved to the left by `shift`, because the pole of the rigid motion at the origin breaks a
    rank condition; eigenvalues and margins are those of the true plant. The controller inverts lightly damped modes of
    its design model, so only low bandwidths hold over a wide spring range.
    """

    method: ClassVar[str] = "mixed_sensitivity"
    tunable: ClassVar[tuple[str, ...]] = (
        "bandwidth",
        "peak",
        "least",
        "torque",
        "roll_off",
        "stiffness_share",
    )

    bandwidth: float = Field(default=6.0, gt=0.0, description="bandwidth wanted of the sensitivity [rad/s]")
    peak: float = Field(default=2.0, gt=0.0, description="largest sensitivity wanted [1]")
    least: float = Field(default=1e-3, gt=0.0, description="sensitivity wanted at low frequency [1]")
    torque: float = Field(default=60.0, gt=0.0, description="gain of the controller that costs 1 [Nm/rad or N/m]")
    roll_off: float = Field(default=200.0, gt=0.0, description="frequency above which T is to fall [rad/s]")
    shift: float = Field(default=1.0, gt=0.0, description="shift of the poles of the design plant to the left [1/s]")
    stiffness_share: float = Field(
        default=0.1, ge=0.0, le=1.0, description="design model between softest (0) and stiffest (1) spring segment [1]"
    )

    def design(self, problem: DesignProblem) -> Design:
        """Design the controller; see `AbstractDesignMethod.design`."""
        import control  # here, because it loads slowly

        plant = delayed_plant(problem, self.stiffness_share, "mixed_sensitivity")
        shifted = control.ss(plant.A - self.shift * np.eye(len(plant.A)), plant.B, plant.C, plant.D)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)  # of control about its own connect()
            whole = control.augw(shifted, *self.weights(control))
        generalised = ContinuousSystem(*(np.asarray(getattr(whole, name), dtype=float) for name in "ABCD"))
        continuous, gamma = h_infinity(generalised, 1, 1, "mixed_sensitivity")
        return Design(tustin(continuous, problem.sample_time), problem.sample_time, None, {"gamma": gamma})

    def weights(self, control: Any) -> tuple[control.TransferFunction, ...]:
        """Return W1, W2 and W3 as python-control systems."""
        first = control.tf([1.0 / self.peak, self.bandwidth], [1.0, self.bandwidth * self.least])
        third = control.tf([1.0, self.roll_off / self.peak], [1e-3, self.roll_off])
        return first, control.tf([1.0 / self.torque], [1.0]), third
