"""Friction of one motor at constant speeds: measured points and all laws that they can tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.identify.friction.laws import LAWS, FrictionFit, fit_law
from flexros.identify.friction.points import FrictionPoints, constant_speed_points

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.logs.time_series import Log


@dataclass(frozen=True, eq=False)
class FrictionMeasurement:
    """Friction of one motor at constant speeds.

    Attributes:
        joint: Name of the motor.
        points: Speeds and torques.
        fits: The laws with fewer parameters than there are points, from poor to rich.
        linear: Whether the motor is prismatic.
    """

    joint: str
    points: FrictionPoints
    fits: tuple[FrictionFit, ...]
    linear: bool = False

    @property
    def best(self) -> FrictionFit | None:
        """The fit with the lowest information criterion of the laws that the speeds determine; None without a fit."""
        determined = [fit for fit in self.fits if np.isfinite(fit.deviations).all()]
        return min(determined or self.fits, key=lambda fit: fit.criterion) if self.fits else None

    @property
    def speed_unit(self) -> str:
        """Unit of the speed."""
        return "m/s" if self.linear else "rad/s"

    @property
    def torque_unit(self) -> str:
        """Unit of the torque."""
        return "N" if self.linear else "Nm"

    def unit(self, parameter: str) -> str:
        """Return the unit of a parameter of a law."""
        viscous = "N s/m" if self.linear else "Nm s/rad"
        slope = "s/m" if self.linear else "s/rad"
        level, speed = self.torque_unit, self.speed_unit
        units = {"f_v": viscous, "v_s": speed, "f_c": level, "f_s_less_f_c": level, "mu_k": "1"}
        return units.get(parameter, slope)

    def record(self) -> dict[str, Any]:
        """Return points and fits for JSON."""
        return {
            "joint": self.joint,
            "points": [
                {"speed": float(v), "torque": float(t), "std": float(s)}
                for v, t, s in zip(self.points.speed, self.points.torque, self.points.spread, strict=True)
            ],
            "offset": self.points.offset,
            "laws": [
                {
                    "name": fit.law.name,
                    "equation": fit.law.equation,
                    "rms": fit.rms,
                    "criterion": fit.criterion,
                    "parameters": {
                        name: {"value": float(value), "std": float(std)}
                        for name, value, std in zip(fit.law.parameters, fit.values, fit.deviations, strict=True)
                    },
                }
                for fit in self.fits
            ],
            "best": None if self.best is None else self.best.law.name,
        }


def measure_friction(logs: Sequence[Log], joint: str, *, linear: bool = False) -> FrictionMeasurement:
    """Fit the laws of equations 3.14 to 3.16 of Moberg (2007) to the phases of constant speed of logs.

    Args:
        logs: Logs of moves at different speeds, with reference velocity and torque.
        joint: Name of the motor.
        linear: Whether it is prismatic.

    Returns:
        The points and the fits.

    Raises:
        InputError: No such joint, a signal is missing, or no phase of constant speed.
    """
    points = constant_speed_points(logs, joint)
    fits = tuple(fit_law(law, points) for law in LAWS if len(points.speed) > len(law.parameters))
    return FrictionMeasurement(joint, points, fits, linear)
