"""The cases of a blind check: what is hidden in how many logs of which robots."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias

from flexros.random_streams import Stream, generator
from flexros.validation.blind.draw.case_robots import case_robot
from flexros.validation.blind.draw.crowd import draw_crowd
from flexros.validation.blind.draw.locations import places_of
from flexros.validation.blind.plant.laws import LAWS, LIBRARY_LAWS, OUTSIDE_LAWS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy as np

Kind: TypeAlias = Literal["single", "null", "unknown", "pair", "crowd"]
Size: TypeAlias = Literal["weak", "medium", "strong", "any", "crowd", "none"]

SIZES: Mapping[Size, tuple[float, float]] = {
    "weak": (20.0, 50.0),
    "medium": (60.0, 500.0),
    "strong": (5e3, 1e6),
    "any": (1e3, 1e6),
    "crowd": (100.0, 1e7),
}
"""Expected gain in log-likelihood that a size is drawn for [nats]; 50 and more is well above the noise."""

ALWAYS_STRONG = ("encoder_quantization",)
"""Effects that are no deviation while they are small, but a property of the sensor."""

NUISANCES = ("exact", "tolerance_1", "tolerance_3")
"""Nominal model: exact, or wrong within 1 % (damping 10 %), or within 3 % (damping 30 %)."""

ORDER = 1_000_001
"""Number of the random stream of the plan, behind those of the cases."""

CONFUSED = (
    {
        "viscous_friction",
        "coulomb_friction",
        "stribeck_friction",
        "presliding_friction",
        "friction_drift",
        "load_dependent_friction",
    },
    {"torque_gain_error", "motor_inertia_error", "payload_error"},
    {"delay", "actuator_lag"},
    {"backlash", "hysteresis", "nonlinear_stiffness", "stiffness_error"},
)
"""Effects of which no two are hidden together, because they would explain each other."""


@dataclass(frozen=True)
class PlanSettings:
    """Numbers and shares of the cases.

    Attributes:
        robots: Share of each robot in the cases, by its name.
        per_size: Cases per effect and size, over all robots.
        nulls: Cases without deviation.
        unknowns: Cases with a cause outside the library.
        pairs: Cases with two effects.
        nuisance: Share of cases whose nominal model is wrong within its tolerance.
        crowds: Cases with 3 to 12 effects.
        crowd_robots: Share of each robot in these.
        crowd_nuisance: Share of these whose nominal model is wrong, all within 3 %.
        crowd_outside: Share of these with a cause outside the library beside the effects.
    """

    robots: Mapping[str, float] = field(
        default_factory=lambda: {"four_mass_linear": 0.45, "four_mass": 0.3, "elbow": 0.15, "e12": 0.1}
    )
    per_size: int = 6
    nulls: int = 400
    unknowns: int = 60
    pairs: int = 80
    nuisance: float = 1 / 3
    crowds: int = 0
    crowd_robots: Mapping[str, float] = field(
        default_factory=lambda: {
            "four_mass_linear": 0.1,
            "four_mass": 0.15,
            "elbow": 0.2,
            "e12": 0.2,
            "six_axis": 0.1,
            "rigid_six_axis": 0.25,
        }
    )
    crowd_nuisance: float = 0.4
    crowd_outside: float = 0.2


@dataclass(frozen=True)
class Case:
    """One case before it is drawn.

    Attributes:
        number: Number of its log; says nothing of what is hidden in it.
        kind: What is hidden.
        robot: Name of the robot.
        effects: Names of what is hidden.
        size: Size of it.
        nuisance: One of `NUISANCES`.
        tool: Whether the tool is measured.
        places: Locations of what is hidden; drawn with the case where there are none.
    """

    number: int
    kind: Kind
    robot: str
    effects: tuple[str, ...]
    size: Size
    nuisance: str
    tool: bool
    places: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of its folder."""
        return f"case_{self.number:04d}"


def plan_cases(settings: PlanSettings, seed: int, stream: Stream = Stream.BLIND_EVALUATION) -> tuple[Case, ...]:
    """List the cases, shuffled so that every beginning of the list is a fair sample.

    Args:
        settings: How many.
        seed: Seed of the check.
        stream: Stream of development or of evaluation.

    Returns:
        The cases; effects that none of the robots can have are left out.
    """
    random = generator(seed, stream, ORDER)
    possible = [name for name in LAWS if any(_fits(name, robot) for robot in settings.robots)]
    drafts: list[tuple[Kind, tuple[str, ...], Size]] = [
        ("single", (effect,), size)
        for effect in possible
        if effect in LIBRARY_LAWS
        for size in ("weak", "medium", "strong")
        if size == "strong" or effect not in ALWAYS_STRONG
        for _ in range(settings.per_size)
    ]  # type: ignore[list-item, unused-ignore]
    drafts += [("null", (), "none")] * settings.nulls
    outside = [name for name in possible if name in OUTSIDE_LAWS]
    drafts += [("unknown", (outside[k % len(outside)],), "any") for k in range(settings.unknowns)]
    drafts += [("pair", _pair(possible, random), "any") for _ in range(settings.pairs)]
    decks = {kind: _Deck(settings, random) for kind in ("single", "null", "unknown", "pair")}
    cases = [_case(draft, decks[draft[0]], random) for draft in drafts] + _crowds(settings, random)
    shuffled = [cases[k] for k in random.permutation(len(cases))]
    return tuple(replace(one, number=number) for number, one in enumerate(shuffled))


class _Deck:
    """Deals robots and nuisances in their shares, in random order.

    Args:
        settings: Shares.
        random: Random numbers.
        robots: Other shares of the robots.
    """

    def __init__(
        self, settings: PlanSettings, random: np.random.Generator, robots: Mapping[str, float] | None = None
    ) -> None:
        self._shares = dict(robots or settings.robots)
        self._given = dict.fromkeys(self._shares, 0.0)
        self._nuisance, self._random, self._dealt, self._wrong = settings.nuisance, random, 0, 0

    def robot(self, effects: tuple[str, ...]) -> str:
        """Deal the robot that lacks most of its share among those where the effects make sense."""
        fit = [name for name in self._shares if all(_fits(effect, name) for effect in effects)]
        short = {name: self._given[name] / self._shares[name] + 0.5 * self._random.uniform() for name in fit}
        name = min(short, key=lambda one: short[one])
        self._given[name] += 1
        return name

    def nuisance(self) -> str:
        """Deal the state of the nominal model."""
        self._dealt += 1
        if self._random.uniform() < self._nuisance * self._dealt - self._wrong:
            self._wrong += 1
            return str(self._random.choice(NUISANCES[1:]))
        return NUISANCES[0]


@cache
def _fits(effect: str, robot: str) -> bool:
    return bool(places_of(effect, case_robot(robot)))


def _case(draft: tuple[Kind, tuple[str, ...], Size], deck: _Deck, random: np.random.Generator) -> Case:
    kind, effects, size = draft
    seen = "kinematic_error" in effects or bool(random.uniform() < 0.5)
    return Case(0, kind, deck.robot(effects), effects, size, deck.nuisance(), seen)


def _crowds(settings: PlanSettings, random: np.random.Generator) -> list[Case]:
    """Draw crowds: robots in their shares, what is hidden, and the state of the nominal model."""
    deck, cases = _Deck(settings, random, settings.crowd_robots), []
    wrong, outside = (
        random.permutation(settings.crowds) < round(share * settings.crowds)
        for share in (settings.crowd_nuisance, settings.crowd_outside)
    )
    for number in range(settings.crowds):
        robot = deck.robot(())
        hidden = draw_crowd(case_robot(robot), bool(outside[number]), random)
        effects, places = (tuple(column) for column in zip(*hidden, strict=True))
        nuisance = NUISANCES[2] if wrong[number] else NUISANCES[0]
        cases.append(Case(0, "crowd", robot, effects, "crowd", nuisance, bool(random.uniform() < 0.5), places))
    return cases


def _pair(possible: Sequence[str], random: np.random.Generator) -> tuple[str, str]:
    """Draw two effects of the library that do not explain each other."""
    rare = {"gravity_error", "kinematic_error", "extra_mode", "friction_drift"}
    names = [name for name in possible if name in LIBRARY_LAWS and name not in rare]
    while True:
        first, second = (str(name) for name in random.choice(names, 2, replace=False))
        if not any({first, second} <= group for group in CONFUSED):
            return first, second
