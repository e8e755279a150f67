"""Tunable structures: controllers as a function of a few positive numbers, for optimisation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.control.design.fixed_structure import BIQUAD, biquad_system, lag_system, lead_lag_system, pid_system
from flexros.control.pid import Pid
from flexros.control.state_space import StateSpace

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.fixed_structure import DiscreteSystem

PID = {"kp": 24.0, "ki": 100.0, "kd": 2.35, "derivative_filter": 2.6e-3}
"""First values of the PID [Nm/rad, Nm/(rad s), Nms/rad, s], those of the controller `pid_check`."""
FREQUENCIES = (40.0, 120.0, 300.0, 700.0, 20.0, 200.0)
"""First frequencies of the second-order sections, in which zeros and poles cancel [rad/s] (chosen)."""
DAMPING = 0.7
"""First damping ratio of zeros and poles [1] (chosen)."""
CORNER = 60.0
"""First corner of zero and pole of a lead-lag [rad/s] (chosen)."""
ACCELERATION = {"high_pass": 1.0, "low_pass": 3e-3}
"""First corner of the high-pass [rad/s] and time constant of the low-pass [s] of the tool acceleration (chosen)."""


@dataclass(frozen=True)
class TunableStructure:
    """PID in series with lead-lags and second-order sections, with or without tool acceleration.

    The torque is K(z) (reference - motor position) + F(z) tool acceleration. K is a PID times `lead_lags` first-order
    and `sections` second-order factors of unit gain at rest; F a gain times high-pass, low-pass and
    `acceleration_sections` second-order factors. All but the gain of F are positive and are searched by their
    logarithm.

    Attributes:
        sections: Number of second-order sections.
        lead_lags: Number of lead-lags.
        acceleration: Whether the tool acceleration is fed back.
        acceleration_sections: Number of second-order sections in its path.
    """

    sections: int = 0
    lead_lags: int = 0
    acceleration: bool = False
    acceleration_sections: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in the order of a vector of parameters."""
        names = list(PID)
        for number in range(1, self.lead_lags + 1):
            names += [f"lead_lag_{number}.zero", f"lead_lag_{number}.pole"]
        for number in range(1, self.sections + 1):
            names += [f"section_{number}.{key}" for key in BIQUAD]
        if self.acceleration:
            names += ["acceleration.gain", *(f"acceleration.{key}" for key in ACCELERATION)]
            for number in range(1, self.acceleration_sections + 1):
                names += [f"acceleration.section_{number}.{key}" for key in BIQUAD]
        return tuple(names)

    @property
    def order(self) -> int:
        """Number of states of the controller."""
        own = 2 + self.lead_lags + 2 * self.sections
        return own + (2 + 2 * self.acceleration_sections if self.acceleration else 0)

    @property
    def text(self) -> str:
        """Return the factors in words."""
        counts = {"lead-lags": self.lead_lags, "second-order sections": self.sections}
        words = [f"{count} {what}" for what, count in counts.items() if count]
        if self.acceleration:
            words.append(f"tool acceleration ({self.acceleration_sections} sections)")
        return ", ".join(words) or "no further factors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors beside the motor encoder."""
        return ("tool_acceleration",) if self.acceleration else ()

    def start(self, known: dict[str, float] | None = None) -> dict[str, float]:
        """Return first values, in which all factors cancel.

        Args:
            known: Values of a simpler structure, which are kept.
        """
        values: dict[str, float] = {}
        for name in self.names:
            part, _, key = name.rpartition(".")
            if name in PID:
                values[name] = PID[name]
            elif part.startswith("lead_lag"):
                values[name] = CORNER
            elif name == "acceleration.gain":
                values[name] = 0.0
            elif part == "acceleration":
                values[name] = ACCELERATION[key]
            elif key.endswith("damping"):
                values[name] = DAMPING
            else:
                values[name] = FREQUENCIES[(int(part.rpartition("_")[2]) - 1) % len(FREQUENCIES)]
        return values | {name: value for name, value in (known or {}).items() if name in values}

    def vector(self, values: dict[str, float]) -> FloatArray:
        """Return the point of the search: logarithms, the gain of the acceleration as it is, shape (n_parameters,)."""
        return np.array([values[name] if name == "acceleration.gain" else np.log(values[name]) for name in self.names])

    def values(self, vector: FloatArray) -> dict[str, float]:
        """Return the values at a point of the search."""
        return {
            name: float(entry if name == "acceleration.gain" else np.exp(entry))
            for name, entry in zip(self.names, vector, strict=True)
        }

    def system(self, values: dict[str, float], sample_time: float) -> DiscreteSystem:
        """Return the controller from [position error, tool acceleration] to the torque."""

        def part(prefix: str, keys: Iterable[str]) -> dict[str, float]:
            return {key: values[prefix + key] for key in keys}

        series = pid_system(**part("", PID), sample_time=sample_time)
        for number in range(1, self.lead_lags + 1):
            corners = part(f"lead_lag_{number}.", ("zero", "pole"))
            series = series.then(lead_lag_system(**corners, sample_time=sample_time))
        for number in range(1, self.sections + 1):
            series = series.then(biquad_system(**part(f"section_{number}.", BIQUAD), sample_time=sample_time))
        if not self.acceleration:
            return series
        path = lag_system(**part("acceleration.", ("gain", *ACCELERATION)), sample_time=sample_time)
        for number in range(1, self.acceleration_sections + 1):
            own = part(f"acceleration.section_{number}.", BIQUAD)
            path = path.then(biquad_system(**own, sample_time=sample_time))
        return series.beside(path)

    def law(self, values: dict[str, float], sample_time: float, *, anti_windup: bool = True) -> AbstractControlLaw:
        """Return the control law.

        Args:
            values: Value of each of `names`.
            sample_time: Time between two samples [s].
            anti_windup: Whether the anti-windup gain is designed; without it the law is made faster.
        """
        if self == TunableStructure():
            return Pid.model_validate({key: values[key] for key in PID})
        return state_space_law(self.system(values, sample_time), sample_time, self.sensors, anti_windup=anti_windup)


def state_space_law(
    system: DiscreteSystem, sample_time: float, sensors: tuple[str, ...] = (), *, anti_windup: bool = True
) -> StateSpace:
    """Return a control law from [position error, further measurements] to the torque.

    Args:
        system: The controller.
        sample_time: Its sample time [s].
        sensors: Measurements beside the error of the motor positions.
        anti_windup: Whether the anti-windup gain is designed; zero without it.
    """
    return StateSpace.model_validate(
        {
            "A": system.A,
            "B": system.B,
            "C": system.C if system.order else [[] for _ in system.D],
            "D": system.D,
            "inputs": ("motor_position_error", *sensors),
            "anti_windup": None if anti_windup else np.zeros((system.order, len(system.D))),
            "matrices_sample_time": sample_time,
        }
    )
