"""What brakes a motor under a servo: viscous friction and the damping of the loop, which act alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.servos import ServoDampingError
from flexros.gap.candidates.candidate import below_nominal
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.robot import Robot

NONE = 0.01
"""Viscous friction over the damping of a servo below which there is none [1] (chosen)."""


@dataclass(frozen=True)
class Braking:
    """What brakes a motor within the limit of its servo, where both parts of it act alike.

    Attributes:
        friction: Viscous friction, as far as it may be sought.
        less: Damping of the servo below that of the robot file.
        damping: Damping in the robot file [Nm s/rad or N s/m].
    """

    friction: Candidate
    less: Candidate
    damping: float

    @property
    def together(self) -> Candidate:
        """Viscous friction that may also take the damping of the servo away."""
        (free,) = self.friction.free
        return replace(self.friction, free=(below_nominal(free, self._taken_away + self._most * self.damping),))

    def named(self, coefficient: float) -> tuple[Candidate, float]:
        """Return what a size of `together` is called, friction where that may be it, with its size there.

        Args:
            coefficient: The size [Nm s/rad or N s/m].
        """
        if coefficient >= -self._taken_away:
            return self.friction, coefficient
        return self.less, coefficient / self.damping

    def is_none(self, coefficient: float) -> bool:
        """Return whether a size of `friction` is the least that there may be, beside the damping of the servo.

        Args:
            coefficient: The size [Nm s/rad or N s/m].
        """
        return coefficient + self._taken_away < NONE * self.damping

    @property
    def _taken_away(self) -> float:
        """Friction of the robot file that there may not be [Nm s/rad or N s/m]."""
        (free,) = self.friction.free
        return free.negative if free.signed and free.negative is not None else 0.0

    @property
    def _most(self) -> float:
        return -float(self.less.free[0].decode(np.array(self.less.free[0].bounds[0])))


def braking_of(candidates: Sequence[Candidate], robot: Robot) -> dict[str, Braking]:
    """Return what brakes motors whose servo may have less damping than in the robot file, by their names."""
    every = {one.name: replace(one, free=one.free[:1]) for one in candidates}
    found = {}
    for motor in robot.joint_names:
        friction, less = (every.get(f"{effect.name}@{motor}") for effect in (ViscousFriction, ServoDampingError))
        if friction is not None and less is not None and less.free[0].positive == 0.0:
            found[motor] = Braking(friction, less, robot.parameters[f"{motor}.{SERVO}damping"].value)
    return found


def freed(fit: CandidateFit, braking: Mapping[str, Braking], null: NullFit) -> CandidateFit:
    """Return a fit whose motors without any viscous friction may have less damping than that; its prediction stays.

    Args:
        fit: The fit.
        braking: What brakes motors, by their names.
        null: The nominal model, fitted.
    """

    def together(one: Candidate, size: float) -> tuple[Candidate, float]:
        known = braking[one.location]
        none = one.effect is ViscousFriction and known.is_none(size)
        return (known.together, size) if none else (one, size)

    return _renamed(fit, braking, together, null)


def named(fit: CandidateFit, braking: Mapping[str, Braking], null: NullFit) -> CandidateFit:
    """Return a fit with what brakes its motors as friction where it may be that, else as less damping.

    The prediction stays.

    Args:
        fit: The fit.
        braking: What brakes motors, by their names.
        null: The nominal model, fitted.
    """

    def name(one: Candidate, size: float) -> tuple[Candidate, float]:
        known = braking[one.location]
        return known.named(size if one.effect is ViscousFriction else size * known.damping)

    return _renamed(fit, braking, name, null)


def _renamed(
    fit: CandidateFit,
    braking: Mapping[str, Braking],
    name: Callable[[Candidate, float], tuple[Candidate, float]],
    null: NullFit,
) -> CandidateFit:
    """Return a fit with other candidates, of other sizes, for what brakes its motors."""
    stated = list(zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True))
    for index, (one, sizes) in enumerate(stated):
        known = braking.get(one.location)
        if known is None or one.name not in (known.friction.name, known.less.name) or len(one.free) > 1:
            continue
        if known.friction.name in fit.names and known.less.name in fit.names:  # as at a torque limit
            continue
        other, size = name(one, sizes[one.free[0].name])
        stated[index] = (other, {other.free[0].name: size})
    return restated(fit, stated, null)


def restated(fit: CandidateFit, stated: Sequence[tuple[Candidate, Mapping[str, float]]], null: NullFit) -> CandidateFit:
    """Return a fit with its effects as other candidates state them; its prediction stays, the fit itself for the same.

    Args:
        fit: The fit.
        stated: Candidates in the order of its own, with the values of their free parameters by name [their units].
        null: The nominal model, fitted.
    """
    hypothesis = tuple(one for one, _ in stated)
    if hypothesis == fit.hypothesis:
        return fit
    sizes = [np.clip(free.encode(values[free.name]), *free.bounds) for one, values in stated for free in one.free]
    predictor, theta = null.predictor(hypothesis), np.concatenate([sizes, fit.deviations])
    chi2 = float(chi2_of(predictor, null.data, theta[:, None])[0])
    return replace(fit, predictor=predictor, theta=theta, chi2=chi2, information=np.zeros((0, 0)))
