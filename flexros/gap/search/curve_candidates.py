"""Curves without a law as candidates: their places, their knots from what a log covers, their free sizes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.effects import effects
from flexros.effects.kinds.curve import AbstractCurve
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.fit.directions import Directions
from flexros.record.one_way import moves_one_way
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.curve import Extent
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

TRIED = 0.05
"""Size of a curve by which a log is predicted, over the largest torque of its motor or spring [1] (chosen)."""
REPEATED = 0.5
"""Share of its whole range that a motor covers between any two knots of a curve over time [1] (chosen)."""
RARE = 1e-3
"""Share of the samples whose deflection is beyond the knots at each end [1] (chosen)."""
WORSE = 0.1
"""Relative rise of the sum of squares up to which knots are moved to where the motion is [1] (chosen)."""
MOVED = 0.1
"""Relative difference of what a log covers from which the knots of a curve are moved [1] (chosen)."""


def list_curves(search: Search, fit: CandidateFit) -> list[Candidate]:
    """List the curves that compete beside an explanation, without the sizes that they share with its laws.

    Beside sensors of the links no curve of a spring competes: what their own laws leave open would go into it.

    Args:
        search: The search.
        fit: The explanation.
    """
    covered = Covered(search, fit)
    candidates = []
    for effect in effects().values():
        if not issubclass(effect, AbstractCurve):
            continue
        if effect.stage == "gear" and search.data.sensors is not None:
            continue
        for location in effect().locations(search.null.model.robot):
            torque = covered.torque(location)
            alike = effect.told_by_reversals and covered.one_way(location)
            if torque <= 0 or alike or not covered.repeatedly(effect, location):
                continue
            fixed = covered.knots(effect, location)
            shown = effect(**dict(fixed)).shown
            shared = _shared(effect, shown, location, fit)
            hidden = {*shared, *(effect.uneven if covered.one_way(location) else ())}
            names = [name for name in shown if name not in hidden]
            sizes = [effect.ranges[name] for name in names]
            starts = TRIED * torque * np.eye(len(names))
            free = tuple(
                FreeParameter(name, size.low * torque, size.high * torque, True, tuple(map(float, start)))
                for name, size, start in zip(names, sizes, starts, strict=True)
            )
            candidates.append(Candidate(effect, location, free, fixed, together=True))
    return [one for one in candidates if search.competitors.contain(one) and one.name not in fit.names]


def without_shared(curve: Directions, others: Sequence[Directions]) -> Directions:
    """Return a curve without the sizes that do the same as those of other curves at its place.

    Args:
        curve: The curve.
        others: Other curves, at any places.
    """
    extends = curve.candidate.effect.extends
    own = {name: (law, other) for law, pairs in extends.items() for name, other in pairs.items()}
    taken = {
        (law, pairs[free.name])
        for one in others
        if one.candidate.location == curve.candidate.location
        for law, pairs in one.candidate.effect.extends.items()
        for free in one.candidate.free
        if free.name in pairs
    }
    kept = np.array([own.get(free.name) not in taken for free in curve.candidate.free], dtype=bool)
    if kept.all():
        return curve
    free = tuple(
        replace(one, starts=tuple(np.array(one.starts)[kept]))
        for one, keeps in zip(curve.candidate.free, kept, strict=True)
        if keeps
    )
    candidate, starts = replace(curve.candidate, free=free), curve.starts[np.ix_(kept, kept)]
    return Directions(candidate, starts, curve.changes[:, kept], curve.usable[kept])


def within_motion(search: Search, fit: CandidateFit) -> CandidateFit:
    """Fit an explanation again with the knots of its curves where its own motion is.

    Springs of the nominal model are turned further, or less far, than those of the machine.

    Args:
        search: The search.
        fit: The explanation.

    Returns:
        The new fit, whose knots the log determines; the same one where the knots hardly move or it fits clearly worse.
    """
    if not any(_of_spring(one) for one in fit.hypothesis) or search.deadline.stops():
        return fit
    covered = Covered(search, fit)
    moved = tuple(
        replace(one, fixed=covered.knots(one.effect, one.location))
        if issubclass(one.effect, AbstractCurve) and _of_spring(one)
        else one
        for one in fit.hypothesis
    )
    pairs = [
        (before, after) for one, other in zip(fit.hypothesis, moved) for before, after in zip(one.fixed, other.fixed)
    ]
    if all(abs(after[1] - before[1]) <= MOVED * abs(before[1]) for before, after in pairs):
        return fit
    again = search.reshaped(fit, moved)
    return again if again.chi2 < (1 + WORSE) * fit.chi2 else fit


class Covered:
    """What a log covers at motors and springs.

    Args:
        search: The log and the nominal model.
        fit: The explanation whose states tell the deflections of springs.
    """

    def __init__(self, search: Search, fit: CandidateFit) -> None:
        self.search, self.robot, self.record = search, search.null.model.robot, search.data.record
        self._fit = fit
        self._states: FloatArray | None = None

    def torque(self, location: str) -> float:
        """Return the largest torque of a motor, or of a spring by its nominal law [Nm or N]."""
        spring = {joint.name: joint.direction.spring for joint in self.robot.joints}.get(location)
        if not isinstance(spring, Spring):
            return self.search.scales.of("torque", location)
        deflection = ca.SX(self.search.scales.of("deflection", location))
        return abs(float(ca.DM(spring.force(deflection, self.robot.parameters[f"{location}.stiffness"].value))))

    def repeatedly(self, effect: type[AbstractCurve], location: str) -> bool:
        """Return whether the motor repeats its motion between any two knots of a curve over time; True for others."""
        if not effect.intervals:
            return True
        position = np.where(self.record.valid, self.record.position[:, self._motor(location)], np.nan)
        parts = [part[np.isfinite(part)] for part in np.array_split(position, effect.intervals)]
        ranges = [np.ptp(part) if len(part) else 0.0 for part in parts]
        return bool(min(ranges) >= REPEATED * (np.nanmax(position) - np.nanmin(position)))

    def one_way(self, location: str) -> bool:
        """Return whether a motor moves in one direction only; False for springs."""
        return location in self.robot.joint_names and moves_one_way(self.record, self._motor(location))

    def knots(self, effect: type[AbstractCurve], location: str) -> tuple[tuple[str, float], ...]:
        """Return the parameters of a curve that state where its first and last knots are."""
        return tuple((name, self._of(extent, location)) for name, extent in effect.extent.items())

    def _of(self, extent: Extent, location: str) -> float:
        record = self.record
        if extent == "largest speed":
            return self.search.scales.of("speed", location)
        if extent == "first time":
            return record.begin
        if extent == "last time":
            return record.begin + record.sample_time * (record.n_samples - 1)
        if extent in ("lowest deflection", "highest deflection"):
            deflection = self._deflection(location)
            if extent == "lowest deflection":
                return min(float(np.quantile(deflection, RARE)), 0.0)
            return max(float(np.quantile(deflection, 1 - RARE)), 0.0)
        position = record.position[record.valid, self._motor(location)]
        return float(position.min() if extent == "lowest angle" else position.max())

    def _motor(self, location: str) -> int:
        return self.robot.joint_names.index(location)

    def _deflection(self, location: str) -> FloatArray:
        """Return the deflection of a spring in the log, motor minus arm coordinate [rad or m], shape (n,)."""
        if self._states is None:
            self._states = self._fit.states(self.search.data)
        index, joint = next((index, one) for index, one in enumerate(self.robot.joints) if one.name == location)
        deflection = -self._states[:, index]
        if joint.motor_coordinate is not None:
            deflection = deflection + self._states[:, self.robot.n_arm + joint.motor_coordinate]
        return np.asarray(deflection[np.isfinite(deflection)], dtype=float)


def _of_spring(candidate: Candidate) -> bool:
    """Return whether a candidate is a curve over the deflection of a spring."""
    return issubclass(candidate.effect, AbstractCurve) and "highest deflection" in candidate.effect.extent.values()


def _shared(effect: type[AbstractCurve], shown: tuple[str, ...], location: str, fit: CandidateFit) -> frozenset[str]:
    """Return the sizes of a curve that do the same as free parameters of laws at its place, one for each of these."""
    fitted = {(one.effect.name, free.name) for one in fit.hypothesis if one.location == location for free in one.free}
    own = {
        (law, parameter): name
        for law, pairs in effect.extends.items()
        for name, parameter in reversed(tuple(pairs.items()))
        if name in shown
    }
    return frozenset(name for parameter, name in own.items() if parameter in fitted)
