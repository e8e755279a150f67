"""Coverage of the intervals of fitted parameters, where plant and library define them in the same way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.effects import effects
from flexros.validation.blind.score.nested import same_place

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flexros.gap.schema import CauseParameter
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.score.answer import Answer

COMPARABLE: Mapping[str, str] = {
    "stiffness_error": "relative",
    "damping_error": "relative",
    "payload_error": "relative",
    "motor_inertia_error": "relative",
    "torque_gain_error": "relative",
    "gravity_error": "relative",
    "torque_bias": "level",
    "coulomb_friction": "level",
    "viscous_friction": "coefficient",
    "load_dependent_friction": "share",
    "delay": "time",
    "actuator_lag": "time_constant",
    "backlash": "gap",
    "torque_saturation": "limit",
    "encoder_eccentricity": "amplitude",
    "transmission_error": "amplitude",
}
"""Number of an effect by which its interval is judged."""
WIDTH = 1.96
"""Half width of a 95 % interval [standard deviations]."""


@dataclass(frozen=True, eq=False)
class FittedSize:
    """Size of a rightly named effect.

    Attributes:
        answer: The case.
        name: Number of the effect that is its size.
        fitted: What was fitted.
        true: The truth, in its unit.
        hidden: What is hidden.
    """

    answer: Answer
    name: str
    fitted: CauseParameter
    true: float
    hidden: Deviation

    @property
    def covered(self) -> bool:
        """Whether the 95 % interval of the fitted size covers the truth."""
        return covers(self.hidden.effect, self.name, self.fitted, self.true)


def fitted_sizes(answers: Sequence[Answer]) -> Iterator[FittedSize]:
    """List the sizes of rightly named single effects.

    Logs whose nominal model is wrong are left out, because a size counts from the model there.

    Args:
        answers: The cases.
    """
    for one in answers:
        if one.truth.kind != "single" or one.truth.nuisance != "exact" or one.first is None or not one.visible:
            continue
        hidden, name = one.truth.deviations[0], COMPARABLE.get(one.first.effect, "")
        right = one.first.effect == hidden.effect
        if right and same_place(one.truth.robot, hidden.location, one.first.location) and name in one.first.parameters:
            yield FittedSize(one, name, one.first.parameters[name], hidden.parameters[name], hidden)


def covers(effect: str, name: str, fitted: CauseParameter, true: float) -> bool:
    """Return whether the 95 % interval of a fitted parameter covers the truth.

    A number that cannot be negative is fitted by its logarithm, in which its interval is symmetric.

    Args:
        effect: Name of the effect.
        name: Name of the number.
        fitted: Its value and standard deviation.
        true: The truth, in its unit.
    """
    if effects()[effect].ranges[name].signed:
        return abs(fitted.value - true) <= WIDTH * fitted.std
    return true > 0 and abs(math.log(fitted.value / true)) <= WIDTH * fitted.std / fitted.value
