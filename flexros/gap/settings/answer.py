"""From fits to an answer: probabilities, tolerances, the gap on held-out data, the next experiment."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class RankingSettings(Settings):
    """From sums of squares to probabilities and a verdict."""

    per_effect: float = Field(
        default=3.0,
        ge=0,
        description="cost of an effect in the log-probability, and the most that each of its parameters costs [nats] "
        "(tempered; development seeds)",
    )
    per_parameter: float = Field(
        default=1.0, ge=0, description="least cost of each further parameter of an effect [nats]"
    )
    plain_form: float = Field(
        default=2e-4,
        ge=0,
        description="model-form error of plain effects, as a share of the gap [1] (development seeds)",
    )
    shaped_form: float = Field(
        default=2e-3,
        ge=0,
        description="the same for effects with a law of their own: friction, backlash, ripple [1] (development seeds)",
    )
    form_over_rest: float = Field(
        default=4.0,
        ge=0,
        description="largest power of the model-form errors of all effects in the deviations of sizes, over what the "
        "explanation leaves above noise [1] (development seeds)",
    )
    along: float = Field(
        default=0.6,
        ge=0,
        description="model-form error of two plain effects that do nearly the same, along the line between their "
        "predictions, over half of its length [1] (development seeds)",
    )
    across: float = Field(
        default=2e-6, ge=0, description="the same across that line, as a share of the gap [1] (development seeds)"
    )
    matters: float = Field(
        default=0.5, ge=0, description="log-likelihood difference above which the model-form error matters [nats]"
    )
    decided: float = Field(
        default=7.0, ge=0, description="log-likelihood difference above which a comparison is decided [nats]"
    )
    significant: float = Field(
        default=4.0,
        gt=0,
        description="standard deviations of the mean squared error without gap beyond which something is left [1] "
        "(development seeds)",
    )
    detected: float = Field(
        default=6.0,
        ge=0,
        description="gain beyond its penalty that an effect must reach to be detected [1] (development seeds)",
    )
    rounded: float = Field(
        default=0.02, ge=0, description="gain per value that coarse rounding of an encoder may feign [1]"
    )
    unexplained: float = Field(
        default=0.1,
        gt=0,
        lt=1,
        description="share of the gap that an explanation may leave, or the cause is unknown [1] (the contract)",
    )
    exact_unexplained: float = Field(
        default=0.02,
        gt=0,
        lt=1,
        description="the same for an exact nominal model, where only model-form errors excuse a remainder [1]: between "
        "effects of another form (up to 0.015) and causes outside the library (from 0.03; development seeds)",
    )
    exact_unexplained_elsewhere: float = Field(
        default=0.035,
        gt=0,
        lt=1,
        description="the same in a log that was not fitted, where effects of another form leave up to 0.025 [1]",
    )
    floors: float = Field(
        default=2.0,
        ge=1,
        description="floors that an explanation may leave in the held-out log, or it is one in part [1]",
    )
    withdrawn: float = Field(
        default=0.03,
        gt=0,
        lt=1,
        description="share of the gap in the held-out log by which predictions 0.1 s ahead must be better without an "
        "effect of a measured log for it to be withdrawn [1]: of four legs of a quadruped robot those that spoiled "
        "another log had 0.06 and 0.39, one that did not 0.01",
    )
    undetermined: float = Field(
        default=1.0,
        ge=0,
        description="size of an effect of a measured log over its standard deviation, with errors of form, below which "
        "it is withdrawn where predictions of the held-out log are no worse without it [1] (chosen: not determined)",
    )
    confirmed_share: float = Field(
        default=0.2,
        gt=0,
        lt=1,
        description="share of the gap in the held-out log from which effects that leave a rest are a part of the truth "
        "[1]",
    )
    constant: float = Field(
        default=10.0,
        gt=0,
        description="size of an effect over its deviation between the parts of a log, from which it is constant [1]: "
        "imitations of causes outside the library reached 9 (14 development cases)",
    )
    parts: int = Field(
        default=8, ge=2, description="parts of equal length that a log is divided into for that [1] (chosen)"
    )
    shown_by_part: float = Field(
        default=3.0,
        ge=0,
        description="size over its standard deviation by a part alone, from which the estimate of that part counts [1] "
        "(chosen): others are noise, whose scatter is not that of the size",
    )
    fewest_parts: int = Field(
        default=4,
        ge=2,
        description="fewest parts that count, from which anything can be said [1] (chosen): two or three agree by "
        "chance",
    )
    inadequate: float = Field(
        default=7.0,
        ge=0,
        description="cost of leaving more than that where another explanation does not [nats]",
    )
    rival: float = Field(
        default=3.0,
        ge=1,
        description="factor of probability within which a rival makes the answer ambiguous [1] (the contract)",
    )
    likely: float = Field(
        default=0.01,
        gt=0,
        lt=1,
        description="probability from which the parameters of an explanation are pruned and get exact errors [1]",
    )
    part_of_unknown: float = Field(
        default=0.1,
        ge=0,
        le=1,
        description="how often the best known effect is part of a gap that it does not explain [1] (development seeds: "
        "3 of 39)",
    )
    confirmed: int = Field(
        default=5, ge=0, description="first effects of the ranking whose gain in the held-out log is computed"
    )


class SensitivitySettings(Settings):
    """Settings of the sensitivity of the names to the tolerances of the nominal model, which nobody has measured."""

    named: float = Field(
        default=0.5, gt=0, lt=1, description="probability from which an effect counts as named at some tolerance [1]"
    )
    refitted: int = Field(
        default=3,
        ge=0,
        description="explanations that are fitted again with halved, and with doubled tolerances, where linear theory "
        "says that another one leads then; few, as each takes as long as in the search",
    )


class PredictionGapSettings(Settings):
    """Settings of the gap of predictions 0.1 s ahead on held-out data."""

    spacing: float = Field(default=0.025, gt=0, description="time between the starts of two predictions [s]")
    block: float = Field(default=1.0, gt=0, description="length of the blocks that the bootstrap draws [s]")
    draws: int = Field(default=400, ge=20, description="draws of the bootstrap for the interval of the closed fraction")
    shows: float = Field(
        default=4.0,
        ge=0,
        description="standard deviations of the gap by noise alone that a gap must exceed the floor by for a closed "
        "fraction [1]",
    )


class NextExperimentSettings(Settings):
    """Settings of the choice of the next experiment."""

    seed: int = Field(
        default=101, ge=0, description="seed of the experiments, another one than a user is likely to have used"
    )
    length: float = Field(default=20.0, gt=0, description="approximate length of an experiment [s]")
    most: int = Field(default=3, ge=2, description="explanations compared, the most probable ones")
    plenty: float = Field(
        default=100.0, gt=0, description="gain from which no further experiment is evaluated: far beyond doubt [nats]"
    )
    enough: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="an experiment earlier in the catalogue, which costs less, is taken where it separates at least "
        "this share of the best one [1]",
    )
