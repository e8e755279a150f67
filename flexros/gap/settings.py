"""Settings of a diagnosis, one group per step; all of them are recorded in the provenance of diagnosis.json."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class FitSettings(Settings):
    """Least-squares fit of one hypothesis."""

    longest_step: float = Field(
        default=1.5,
        gt=0,
        description="longest step of an effect's parameter in one iteration [1]; a factor of 4.5 where the fit moves "
        "the logarithm",
    )
    enough: float = Field(
        default=0.1,
        gt=0,
        description="fall of the sum of squares below which a fit ends [1]; the null needs it so fine",
    )
    exactly: float = Field(
        default=1e-3,
        gt=0,
        description="the same for final fits [1]: intervals of slow effects are tighter than white residuals suggest",
    )
    hope: float = Field(
        default=10.0,
        gt=0,
        description="a fit ends early where this many times the fall that linear theory predicts does not reach its "
        "rival [1]",
    )
    most_starts: int = Field(default=96, ge=1, description="most initial values of one hypothesis [1]")
    null_iterations: int = Field(default=60, ge=1, description="iterations of the fit of the nominal model")
    first_iterations: int = Field(default=4, ge=1, description="iterations of the first fit of a candidate")
    joint_iterations: int = Field(default=5, ge=1, description="iterations of the first fit of several effects")
    final_iterations: int = Field(default=20, ge=1, description="iterations of the fits that are finished")


class SearchSettings(Settings):
    """Which hypotheses are fitted."""

    effects: tuple[str, ...] = Field(default=(), description="names of the effects that compete; empty: all")
    steep: float = Field(
        default=0.5,
        gt=0,
        lt=1,
        description="a first fit goes on while its iterations lower the sum of squares to less than this share [1]",
    )
    settled: int = Field(
        default=3, ge=0, description="a fit that converges in so many iterations needs no second initial value"
    )
    finished: int = Field(default=6, ge=1, description="fits that are carried to their end")
    extended: int = Field(default=3, ge=1, description="best explanations that a further effect is added to")
    added: int = Field(
        default=5, ge=1, description="candidates that are fitted in addition to each of them, by predicted gain"
    )
    most_effects: int = Field(default=4, ge=1, description="most effects in one explanation")
    removed: float = Field(
        default=0.4,
        gt=0,
        lt=1,
        description="share of the remaining gap that a further effect must remove [1]; spurious ones remove up to 0.3 "
        "(development seeds)",
    )
    removed_of_all: float = Field(
        default=0.3,
        gt=0,
        lt=1,
        description="the same on a real machine, where the floor is a matter of tolerance: of all that is left [1]",
    )
    tried_orders: int = Field(
        default=5, ge=1, description="orders of a rotor that are fitted: the most prominent and the largest, each"
    )
    fastest_order: float = Field(
        default=0.4, gt=0, le=0.5, description="highest frequency of an order, relative to the sampling frequency [1]"
    )


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


class DiagnosisSettings(Settings):
    """Settings of a diagnosis."""

    level: float = Field(
        default=2e-4, gt=0, description="torque noise that the predictor allows for, relative: see `observer_gain` [1]"
    )
    fitted_share: float = Field(
        default=2 / 3, gt=0, lt=1, description="share of the log that is fitted to where there is no second one [1]"
    )
    threads: int = Field(default=0, ge=0, description="fits at the same time; 0: as many as there are cores")
    seed: int = Field(default=1, ge=0, description="seed of the simulated logs without gap")
    where: bool = Field(default=True, description="whether the locations of the gap are computed")
    next_experiment: bool = Field(
        default=True, description="whether an experiment is chosen where the answer is ambiguous"
    )
    fit: FitSettings = FitSettings()
    search: SearchSettings = SearchSettings()
    ranking: RankingSettings = RankingSettings()
