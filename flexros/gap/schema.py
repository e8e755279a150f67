"""The result of a diagnosis as a file: `diagnosis.json`."""

from __future__ import annotations

from typing import Any, Literal, Protocol

from pydantic import Field

from flexros.config.settings import Settings

ORDER = (
    "what closes most of the held-out gap first, equal ones by probability; those behind whose sizes are less than two "
    "standard deviations"
)
"""Order of the causes."""
ANSWERED, NEXT_EXPERIMENT = "answer", "next experiment"
"""Last steps of a diagnosis: the answer is put together, and in it the next experiment chosen."""
RIVALS, SIZES, BUDGET = "predictions of rivals", "sizes of rivals", "budget"
GAINS, SHORT_EVENTS, GAP_ALONE = "gains on held-out data", "short events", "gap before alone"
REST, CLOSED_LOOP = "rest of the log", "closed loop"
"""Parts of an answer that it can do without where there is no time for them."""
Verdict = Literal["no_gap", "explained", "partly_explained", "ambiguous", "unknown_effect"]


class CauseParameter(Settings):
    """A fitted parameter."""

    value: float = Field(description="fitted value, in `unit`")
    std: float = Field(description="its standard deviation, in the same unit")
    unit: str = Field(description="SI unit, 1 for none")
    at_limit: bool = Field(
        default=False,
        description="whether the search ended at its limit: no finding; an effect whose size is there is neither in "
        "the patch nor in `budget` and `model_numbers`",
    )
    determined: bool = Field(
        default=True, description="whether the log determines it: false where `std` is above the size of `value`"
    )


class EffectLocation(Settings):
    """An effect at a location."""

    effect: str = Field(description="name of the effect")
    location: str = Field(description="joint, spring, body, 'tool', 'base' or 'all'")


class Located(Protocol):
    """What an effect at a location has: a cause, a candidate of the ranking, a share of the budget."""

    @property
    def effect(self) -> str | None:
        """Name of the effect."""

    @property
    def location(self) -> str:
        """Its location."""


def same_effect(one: Located, other: Located) -> bool:
    """Return whether both are the same effect at the same location."""
    return (one.effect, one.location) == (other.effect, other.location)


class Cause(EffectLocation):
    """An effect that is probably part of the truth."""

    probability: float = Field(ge=0.0, le=1.0, description="that this effect is part of the truth [1]")
    parameters: dict[str, CauseParameter] = Field(description="fitted parameters of the effect")
    closed_fraction: float | None = Field(
        description="share of the gap that it alone closes on held-out data [1]: fitted alone, or else added first"
    )
    determined: bool = Field(
        default=True,
        description="whether the log determines any of its sizes; else the verdict sentence names it only where no "
        "other cause closes any of the gap",
    )


class Excess(Settings):
    """A location where the gap shows, computed without any hypothesis."""

    signal: str = Field(
        description="'position' or 'sudden position change' of a motor, 'tool', the quantity of a further sensor (e.g. "
        "'link position', 'joint torque'), or the lines of a multisine (e.g. 'odd detection lines')"
    )
    joint: str = Field(description="joint name, or 'tool'")
    band_hz: tuple[float, float] = Field(description="frequency band [Hz]")
    regime: str = Field(description="part of the motion, e.g. 'reversal', 'standstill', 'all'")
    share: float = Field(description="share of the whole excess that is here [1]")
    p_value: float = Field(description="probability of such an excess without gap, over all locations tested [1]")


class GapNumbers(Settings):
    """The gap between robot and model, on held-out data."""

    metric: str = Field(description="quantity of these numbers")
    unit: str = Field(description="their unit")
    before: float = Field(description="with the nominal model as it was given")
    before_alone: float | None = Field(
        default=None,
        description="the same with the prediction tied to the encoders as closely as the nominal model needs it, as "
        "`flexros gap` states it; `before` and `after` are tied as loosely as the explanation allows, where "
        "predictions stray farther; none where that is the same",
    )
    after: float | None = Field(default=None, description="with the repaired model")
    noise_floor: float = Field(description="without any gap")
    tolerance_floor: float | None = Field(
        default=None,
        description="with torques that are off by their stated tolerance, for logs of real machines: up to twice this "
        "may be left by an explanation",
    )
    best_rival: float | None = Field(default=None, description="with the best explanation that was not chosen")
    closed_fraction: float | None = Field(
        default=None, description="(before - after) / (before - floor) [1]; none where the gap does not show"
    )
    interval: tuple[float, float] | None = Field(default=None, description="95 % interval of the closed fraction [1]")


class BudgetShare(Settings):
    """The share of the gap that an effect, or a class of effects at a joint, makes up on held-out data."""

    joint: str = Field(description="joint of the effect; its location where that belongs to no joint")
    cause_class: str = Field(
        alias="class",
        description="'friction', 'gear', 'structure', 'load', 'actuator', 'sensor', 'timing' or 'model numbers'",
    )
    effect: str | None = Field(description="name of the effect; none for a whole class")
    location: str = Field(description="location of the effect, or the joint of the class")
    share_first: float | None = Field(
        description="share of the gap that closes when it alone is added to the model [1]; none for a number that the "
        "model lacks and without which it predicts nothing"
    )
    share_last: float | None = Field(
        description="share of the gap that opens when it alone is removed from the repaired model [1]"
    )
    interval: tuple[float, float] | None = Field(description="95 % interval of `share_first` [1]")
    interval_last: tuple[float, float] | None = Field(default=None, description="95 % interval of `share_last` [1]")


class Step(EffectLocation):
    """A step of a waterfall: what an effect closes of the gap at a joint, in addition to those before it."""

    share: float = Field(description="share of the gap of all joints [1]; below zero where the gap at this one grows")


class Waterfall(Settings):
    """The gap at a joint on held-out data, from the nominal model to the repaired one; `before` - steps = `left`."""

    joint: str = Field(description="joint name")
    before: float = Field(description="with the nominal model, as a share of the gap of all joints [1]; 0 is the floor")
    steps: tuple[Step, ...] = Field(description="effects of all joints, first what closes most of the gap of all")
    left: float = Field(description="with the repaired model, in the same unit [1]")


class BandShare(Settings):
    """The part of an unexplained share that lies in a frequency band."""

    band_hz: tuple[float, float] = Field(description="frequency band of the prediction errors [Hz]")
    share: float = Field(description="share of the gap [1]")


class Unexplained(Settings):
    """A share of the gap that the repaired model leaves on held-out data."""

    joint: str = Field(description="joint name")
    regime: str = Field(description="part of the motion, e.g. 'reversal', 'all'")
    share: float = Field(description="share of the gap [1]")
    bands: tuple[BandShare, ...] = Field(
        default=(),
        description="the same divided among frequency bands, up to 100 Hz or half the sampling frequency",
    )


class ModelNumber(Settings):
    """A parameter of the nominal model that the log contradicts."""

    location: str = Field(description="location of the effect that corrects it")
    name: str = Field(description="name of the parameter in the robot")
    nominal: float = Field(description="value in the robot file, in `unit`")
    value: float = Field(description="fitted value, in `unit`")
    std: float = Field(description="its standard deviation, in `unit`")
    unit: str = Field(description="SI unit, 1 for none")
    determined: bool = Field(
        default=True,
        description="whether the log determines it: false at the limit of its search, and where `std` is above the "
        "difference of `value` and `nominal`",
    )
    at_limit: bool = Field(
        default=False,
        description="whether it ended at the limit of its search, five to twenty tolerances: the true number may be "
        "farther off, or it stands for something else",
    )


class ToleranceSensitivity(EffectLocation):
    """The probability of an effect with all stated tolerances of the nominal model halved and doubled."""

    halved: float = Field(description="with half the tolerances [1]")
    stated: float = Field(description="with the tolerances of the robot file, or those given instead [1]")
    doubled: float = Field(description="with twice the tolerances [1]")
    changes: bool = Field(description="whether it is named with some of them and not with others; then it is ambiguous")


class NextExperiment(Settings):
    """The experiment that separates the explanations that the log does not."""

    name: str = Field(description="name in the catalogue")
    description: str = Field(description="instructions")
    separates: tuple[EffectLocation, ...] = Field(description="the explanations that it separates")
    expected_gain: float = Field(description="expected logarithm of the odds of the two closest [nats]")
    command: str = Field(default="", description="command that runs it, where there is one")


class Partial(Settings):
    """What a diagnosis lacks that was ended before its search was complete."""

    reason: Literal["time_limit", "interrupted"] = Field(description="what ended the search")
    after: float = Field(description="time from the begin of the diagnosis to the end of the search [s]")
    step: str = Field(description="step that was cut short first, e.g. 'single effects'; later ones are missing")
    left_out: tuple[str, ...] = Field(
        default=(), description="parts of the answer that there was no time for, e.g. 'budget'"
    )


class Diagnosis(Settings):
    """The answer of a diagnosis; written as `diagnosis.json`."""

    schema_version: int = Field(default=2, alias="schema", description="version of this schema")
    verdict: Verdict = Field(description="the verdict")
    causes: tuple[Cause, ...] = Field(description=ORDER)
    ambiguity_groups: tuple[tuple[EffectLocation, ...], ...] = Field(
        description="effects that the log does not separate; one alone: it does not show whether that is there"
    )
    where: tuple[Excess, ...] = Field(description="where the gap shows, before any hypothesis")
    gap: GapNumbers = Field(description="gap before and after the repair")
    budget: tuple[BudgetShare, ...] = Field(default=(), description="the gap divided among effects, the largest first")
    waterfall: tuple[Waterfall, ...] = Field(
        default=(), description="the gap at each joint, an effect at a time; none where no effect was found"
    )
    unexplained: tuple[Unexplained, ...] = Field(
        default=(), description="what the repaired model leaves, by joint, regime and band, the largest first"
    )
    model_numbers: tuple[ModelNumber, ...] = Field(
        default=(), description="parameters of the nominal model that are wrong beyond their tolerance"
    )
    tolerance_sensitivity: tuple[ToleranceSensitivity, ...] = Field(
        default=(),
        description="effects that are named with the stated, halved or doubled tolerances, those that change first; "
        "none for simulated logs and for models without tolerances",
    )
    next_experiment: NextExperiment | None = Field(description="experiment to run next; none where nothing is open")
    partial: Partial | None = Field(
        default=None, description="where the search was ended before it was complete, what is missing; else none"
    )
    warnings: tuple[str, ...] = Field(description="limits of the answer, a sentence each")
    provenance: dict[str, Any] = Field(description="log, model, versions and settings")
