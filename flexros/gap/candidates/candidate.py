"""Candidate causes: an effect, its location and its free parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.effects import PlacedEffect, effects
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import AbstractEffect
    from flexros.effects.kinds.ranges import Range
    from flexros.effects.patching.placement import PlacedLaw
    from flexros.gap.candidates.scales import Scales
    from flexros.robot import Robot

ASYMMETRY = "asymmetry"
"""Parameter by which friction differs between the directions."""


AT_LIMIT = 1e-3
"""Distance from a limit of the search, over the whole range in the unit of the fit, that counts as at the limit [1]."""
REDUCED = (0.3, 0.6, 0.9)
"""Shares of a nominal number that are taken away in the initial values of a search [1] (chosen)."""
WIDER = 10.0
"""Factor by which a search that ended at its limit is widened (chosen)."""
OF_NUMBERS = ("relative", "coefficient")
"""Sizes of effects that are errors of a number of the model: over it, or in its unit."""


@dataclass(frozen=True)
class FreeParameter:
    """A fitted parameter of an effect. The fit moves the logarithm of positive ones, and signed ones over `high`.

    Attributes:
        name: Name within the effect.
        low: Smallest size [its unit].
        high: Largest size [its unit].
        signed: Whether it may be negative.
        starts: Initial values of the fit [its unit].
        negative: Largest size of negative values, not above `high` [its unit]; None: `high`.
        positive: Largest size of positive values, not above `high` [its unit]; None: `high`.
        fine: Step of the differences that make the derivatives, over the usual one [1].
        vanishes: Bound near which the effect of the parameter vanishes, see `Range`.
        widest: Largest size that a search which ends at `high` goes on to [its unit]; None where it ends there.
        least: Value at which nothing is left of a nominal number, a finding and no limit of the search [its unit]; None
            where it takes nothing away.
    """

    name: str
    low: float
    high: float
    signed: bool
    starts: tuple[float, ...]
    negative: float | None = None
    positive: float | None = None
    fine: float = 1.0
    vanishes: Literal["low", "high", "never"] = "low"
    widest: float | None = None
    least: float | None = None

    def encode(self, value: float) -> float:
        """Convert a value [its unit] to the unit of the fit [1]."""
        return value / self.high if self.signed else float(np.log(max(value, self.low)))

    def decode(self, encoded: FloatArray) -> FloatArray:
        """Convert from the unit of the fit [1] to values [its unit]."""
        if not self.signed:
            return np.exp(encoded)
        sizes = encoded * self.high
        return sizes if self.least is None else np.maximum(sizes, self.least)

    @property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest value in the unit of the fit [1]."""
        if not self.signed:
            return float(np.log(self.low)), float(np.log(self.high))
        sizes = (self.high if limit is None else min(self.high, limit) for limit in (self.negative, self.positive))
        below, above = (size / self.high for size in sizes)
        return -below, above


@dataclass(frozen=True)
class Candidate:
    """An effect at a location, with unknown parameters.

    Attributes:
        effect: Class of the effect.
        location: Motor, spring, body, "tool", "base" or "all".
        free: The fitted parameters.
        fixed: Other parameters that are not at their defaults.
        together: Whether initial values belong together, one of each parameter; else all combinations count.
    """

    effect: type[AbstractEffect]
    location: str
    free: tuple[FreeParameter, ...]
    fixed: tuple[tuple[str, float | bool], ...] = ()
    together: bool = False

    @property
    def name(self) -> str:
        """Effect and location, e.g. "coulomb_friction@motor_1"."""
        return f"{self.effect.name}@{self.location}"

    @property
    def cuts_off(self) -> bool:
        """Whether it limits the torque of a motor."""
        return issubclass(self.effect, AbstractCommandLaw) and self.effect.cuts_off

    def motors(self, robot: Robot) -> list[int]:
        """List the indices of the motors where it acts: its own one, or every motor of "all"."""
        return [motor for motor, name in enumerate(robot.joint_names) if self.location in ("all", name)]

    def starts(self, *, of_one_size: bool = False) -> list[tuple[float, ...]]:
        """List initial values of all free parameters in the units of the fit.

        Args:
            of_one_size: Whether of the initial values of the size of a law that others shape the middle one alone
                counts, of each sign; linear theory scales it.
        """
        encoded = [[free.encode(value) for value in free.starts] for free in self.free]
        if self.together:
            return list(zip(*encoded, strict=True))
        if of_one_size and len(self.free) > 1 and issubclass(self.effect, AbstractLaw):
            for free, values in zip(self.free, encoded, strict=True):
                signs = [[one for one in values if (one > 0) == above] for above in (False, True)]
                if free.name == self.effect.size:
                    values[:] = [own[len(own) // 2] for own in (signs if free.signed else [values]) if own]
        return list(product(*encoded))

    @property
    def resonates(self) -> bool:
        """Whether a frequency is free: from one far off a resonance no fit comes to it, so that many are tried."""
        return any(self.effect.ranges[free.name].scale == "frequency" for free in self.free)

    def neutral(self, free: FreeParameter) -> float | None:
        """Return the value of a parameter that switches the effect off, in the unit of the fit.

        Positive parameters come as close to it as their range allows. None for parameters that shape an effect, such as
        a frequency.
        """
        if self.effect.shaped_by(free.name):
            return None
        return 0.0 if free.signed else free.bounds[free.vanishes == "high"]

    def at_limit(self, values: Mapping[str, float]) -> frozenset[str]:
        """Return the names of the parameters whose values are at a limit of the search, neutral ones excepted.

        Args:
            values: Values of the free parameters by name [their units].
        """
        return frozenset(free.name for free in self.free if self._at_limit(free, free.encode(values[free.name])))

    def _at_limit(self, free: FreeParameter, encoded: float) -> bool:
        low, high = free.bounds
        margin = AT_LIMIT * (high - low)
        neutral = self.neutral(free)
        none_left = None if free.least is None else free.encode(free.least)
        ends = [limit for limit in (low, high) if limit not in (neutral, none_left)]
        reached = [limit for limit in ends if abs(encoded - limit) <= margin]
        return bool(reached) and self.effect.ranges[free.name].scale != "phase"

    def widened(self, name: str) -> Candidate | None:
        """Return the candidate with a parameter free up to ten times its largest size; None where its range ends there.

        Args:
            name: Name of a free parameter.
        """
        free = next(free for free in self.free if free.name == name)
        if free.widest is None or free.high >= free.widest:
            return None
        wide = replace(free, high=min(WIDER * free.high, free.widest))
        return replace(self, free=tuple(wide if one is free else one for one in self.free))

    def with_usual(self, name: str) -> Candidate | None:
        """Return the candidate with a parameter that shapes it fixed at the middle of its initial values.

        Bristles that are so stiff that the log does not show them are none, and so with overtones.

        Args:
            name: Name of a free parameter.

        Returns:
            The candidate; None for a parameter of its size, without which nothing is left.
        """
        if name in self.effect.unsaid:
            return self.without_unsaid()
        free = next(free for free in self.free if free.name == name)
        if self.neutral(free) is not None:
            return None
        usual = sorted(free.starts)[len(free.starts) // 2]
        others = tuple(other for other in self.free if other is not free)
        return replace(self, free=others, fixed=(*self.fixed, (name, usual)), together=False)

    def without_unsaid(self) -> Candidate:
        """Return the candidate as it competes, without what is fitted once it is found, such as bristles."""
        return replace(self, free=tuple(free for free in self.free if free.name not in self.effect.unsaid))

    def without_part(self, name: str) -> Candidate | None:
        """Return the candidate without a parameter beside its size, nor those that shape nothing else.

        Args:
            name: Name of a free parameter.

        Returns:
            The candidate; None for its size, and for what is no law or a curve.
        """
        if not issubclass(self.effect, AbstractLaw) or issubclass(self.effect, AbstractCurve):
            return None
        part = next((set(shared) for shared in self.effect.extends.values() if name in shared), {name})
        rest = replace(self, free=tuple(free for free in self.free if free.name not in part), together=False)
        return None if self.effect.size in part or not rest.free else rest

    def placed(self, values: Mapping[str, float]) -> PlacedEffect:
        """Make the effect with values of the free parameters by name [their units]."""
        return PlacedEffect(self.effect(**{**dict(self.fixed), **values}), self.location)

    def typical(self) -> PlacedEffect:
        """Make the effect with one initial value of each parameter, none of them neutral."""
        return self.placed({free.name: free.starts[len(free.starts) // 2] for free in self.free})


Hypothesis = tuple[Candidate, ...]
"""Effects that act together; the empty one is the nominal model."""


def simpler(candidate: Candidate) -> frozenset[str]:
    """Return the names of the candidates at the same location that a candidate extends."""
    return frozenset(f"{name}@{candidate.location}" for name in candidate.effect.extends)


def is_uneven(candidate: Candidate) -> bool:
    """Return whether a candidate is friction that may differ by direction."""
    return any(free.name == ASYMMETRY for free in candidate.free)


def alike(one: Candidate, other: Candidate) -> bool:
    """Return whether two candidates at the same place look alike in a regression of torques.

    So do relative errors of plain numbers, and what an effect is `taken_for`, as a weight that a wrong zero turns for
    a constant torque.
    """
    if one.location != other.location:
        return False
    if one.effect.name in other.effect.taken_for or other.effect.name in one.effect.taken_for:
        return True
    return all(each.effect.plain and "relative" in each.effect.ranges for each in (one, other))


def own_numbers(hypothesis: Hypothesis, robot: Robot) -> frozenset[str]:
    """Return the numbers of a robot that a hypothesis has errors of.

    A log cannot tell such an error from a tolerated deviation of the same number.

    Args:
        hypothesis: The hypothesis.
        robot: The nominal robot.
    """
    errors = [one for one in hypothesis if any(free.name in OF_NUMBERS for free in one.free)]
    return frozenset(name for one in errors for name in one.effect().numbers(robot, one.location))


def names_of(hypothesis: Hypothesis) -> frozenset[str]:
    """Return the names of the candidates of a hypothesis."""
    return frozenset(candidate.name for candidate in hypothesis)


def name_of(hypothesis: Hypothesis) -> str:
    """Return the name of a hypothesis: its candidates, or "nothing"."""
    return " + ".join(candidate.name for candidate in hypothesis) or "nothing"


def free_parameter(name: str, allowed: Range, scale: float) -> FreeParameter:
    """Convert the range of a parameter to the scale of a log.

    Args:
        name: Name within the effect.
        allowed: Its range, as multiples of the scale.
        scale: Scale of the log [unit of the parameter].
    """
    low, high = allowed.low * scale, allowed.high * scale
    negative = high if allowed.negative is None else allowed.negative * scale
    if isinstance(allowed.starts, tuple):
        starts = tuple(start * scale for start in allowed.starts)
    elif allowed.signed:
        half = np.geomspace(low, high, max(1, (allowed.starts + 1) // 2) + 1)[:-1]
        starts = tuple(
            float(sign * min(size, limit)) for size in half for sign, limit in ((1.0, high), (-1.0, negative))
        )
    else:
        # the middle of equal parts of the logarithmic range
        parts = (np.arange(allowed.starts) + 0.5) / allowed.starts
        starts = tuple(float(x) for x in low * (high / low) ** parts)
    positive, widest = (None if size is None else size * scale for size in (allowed.positive, allowed.widest))
    return FreeParameter(
        name, low, high, allowed.signed, starts, negative, positive, vanishes=allowed.vanishes, widest=widest
    )


def below_nominal(free: FreeParameter, most: float) -> FreeParameter:
    """Extend the search of a parameter that adds to a nominal number to negative values.

    Args:
        free: The parameter, not signed.
        most: The nominal number, which the parameter takes away at most [unit of the parameter].
    """
    starts = (*free.starts, *(-share * most for share in REDUCED))
    return replace(free, high=max(free.high, most), signed=True, starts=starts, negative=most, least=-most)


def from_zero(free: FreeParameter, high: float | None = None) -> FreeParameter:
    """Let a fit move a parameter that is not signed itself, not its logarithm.

    A logarithm that a fit has moved far down hardly changes the prediction any more, and does not come back. The number
    itself ends at zero and leaves it once the rest of the fit allows for that.

    Args:
        free: The parameter.
        high: Largest size, the unit of the fit, if not that of the parameter [its unit].
    """
    if free.signed:
        return free
    return replace(free, high=free.high if high is None else min(free.high, high), signed=True, negative=0.0)


def list_candidates(
    robot: Robot,
    scales: Scales,
    *,
    measured: bool = False,
    known: Sequence[PlacedLaw] = (),
    for_curve: bool = False,
) -> tuple[Candidate, ...]:
    """List every effect at every location, but for effects without ranges, those with a harmonic, and curves.

    The orders of harmonics are found in the prediction errors, see `flexros.gap.search.periodic`. Curves compete in
    what laws leave, see `flexros.gap.search.curves`.

    Args:
        robot: The nominal robot.
        scales: Largest torques, speeds and deflections of the log, and the frequencies that it shows.
        measured: Whether the log is one of a real machine, whose nominal numbers may also be far too large.
        known: Laws of the nominal model, whose sizes may be too large as well.
        for_curve: Whether those are listed that are tried in place of a curve.
    """
    candidates: list[Candidate] = []
    for effect in effects().values():
        if not effect.ranges or effect.harmonics or issubclass(effect, AbstractCurve):
            continue
        for location in distinct_locations(effect, robot, measured=measured, for_curve=for_curve):
            free = candidate_at(effect, location, robot, scales).free
            there = [law.effect for law in known if law.location == location]
            reduced = effect().reductions(robot, location, there) if measured or effect.seeks_less else {}
            free = tuple(below_nominal(one, reduced[one.name]) if reduced.get(one.name) else one for one in free)
            candidates.append(Candidate(effect, location, free, together=effect.together))
    return tuple(candidates)


def candidate_at(effect: type[AbstractEffect], location: str, robot: Robot, scales: Scales) -> Candidate:
    """Return the candidate of an effect at a location, with its own ranges.

    Args:
        effect: The effect.
        location: One of its locations.
        robot: The nominal robot.
        scales: Largest torques, speeds and deflections of the log, and the frequencies that it shows.
    """
    ranges = effect().fitted(robot, location)
    free = (free_parameter(name, scales.shown(one), scales.of(one.scale, location)) for name, one in ranges.items())
    return Candidate(effect, location, tuple(free), together=effect.together)


def distinct_locations(
    effect: type[AbstractEffect], robot: Robot, *, measured: bool = False, for_curve: bool = False
) -> tuple[str, ...]:
    """List the distinct locations where an effect is sought: on a robot with one motor, "all" is that motor.

    Args:
        effect: The effect.
        robot: The nominal robot.
        measured: Whether the log is one of a real machine.
        for_curve: Whether it is sought in place of a curve.
    """
    locations = effect().locations(robot)
    if "all" in locations and robot.n_motors == 1:
        locations = tuple(location for location in locations if location not in robot.joint_names)
    one = effect()
    sought = one.sought_for_curve if for_curve else one.sought_if_measured if measured else one.sought
    return tuple(location for location in locations if sought(robot, location))
