"""Settings of a diagnosis, one group per step; all of them are recorded in the provenance of diagnosis.json."""

from __future__ import annotations

import os
from typing import Literal

from pydantic import Field

from flexros.config.settings import Settings


class NoiseSettings(Settings):
    """Settings of the encoder noise that a log shows."""

    still: float = Field(default=0.25, gt=0, description="shortest standstill that noise is measured in [s]")
    still_samples: int = Field(
        default=400, ge=1, description="samples at standstill from which noise is measured there, else above the band"
    )
    differs: float = Field(
        default=0.2, gt=0, description="relative difference from the robot file from which a warning is given [1]"
    )
    as_declared: float = Field(
        default=0.06, ge=0, description="relative difference up to which noise counts as that of the robot file [1]"
    )
    implausible: float = Field(
        default=0.3,
        ge=0,
        description="measured over declared noise below which positions of a real machine were filtered or rounded, so "
        "that the declared noise is used [1]",
    )
    measured_error: float = Field(
        default=0.01,
        ge=0,
        description="relative error of the variance of measured white noise (tuned on development seeds) [1]",
    )
    coloured_error: float = Field(
        default=0.03, ge=0, description="the same of coloured noise (tuned on development seeds) [1]"
    )
    rounding_error: float = Field(
        default=0.1,
        ge=0,
        description="relative error of the variance of quantization, which is not white where a motor is slow [1]",
    )
    coarse_step: float = Field(
        default=6.0,
        gt=0,
        description="step of an encoder over its declared noise, rms, from which rounding is an effect; finer steps "
        "are a property of the sensor and part of its noise; a declared noise that is rounding alone is 3.5 times "
        "smaller than its step [1]",
    )
    doubt: float = Field(
        default=0.5,
        ge=0,
        description="error of the variance over the difference between the noise of a log and the noise assumed [1]",
    )
    signal_tolerance: float = Field(
        default=0.05,
        ge=0,
        description="share of the rms of a torque that counts as no gap, for logs of real machines, where nothing was "
        "repeated [1]",
    )


class ResidualSettings(Settings):
    """Settings of the weighted prediction errors."""

    starting_level: float = Field(
        default=0.3,
        gt=0,
        description="relative torque noise of the predictor that finds the initial state of a log that begins in "
        "motion [1]",
    )
    far_off: float = Field(
        default=1e4,
        gt=0,
        description="mean squared prediction error over its floor from which on the nominal model is far off: the "
        "predictor follows the encoders more closely then, in steps of ten of its torque noise up to `starting_level`, "
        "and if that does not help, the search begins with what the torques show, as on a real machine [1]",
    )
    at_rest: float = Field(
        default=10.0,
        gt=0,
        description="prediction errors from rest, over their noise, up to which a log begins at rest [1]",
    )
    lost_commands: float = Field(
        default=20.0,
        ge=0,
        description="decrease of the weighted sum of squares from which short holes in the commands are lost commands, "
        "not held ones [1]",
    )
    least_left: float = Field(
        default=0.3, gt=0, le=1, description="share of a log that lost commands must leave for the fit [1]"
    )
    tool_poses: int = Field(
        default=10_000, ge=10, description="largest number of tool poses used; of more, every second, third ... is"
    )
    sensor_values: int = Field(
        default=100_000,
        ge=100,
        description="largest number of values of all further sensors together; of more, every second, third ... is",
    )


class WhereSettings(Settings):
    """Settings of the search for the locations of a gap."""

    realisations: int = Field(default=200, ge=20, description="simulated logs without a gap, for p-values [1]")
    floor: Literal["estimated", "predicted"] = Field(
        default="estimated",
        description="level of the noise: estimated from the highest octave of the log, or the standard deviations of "
        "the predictor",
    )
    lowest_hz: float = Field(default=2.0, gt=0, description="least upper end of the lowest octave band [Hz]")
    orders: float = Field(default=60.0, gt=1, description="highest order evaluated [periods per turn of the rotor]")
    least_freedom: float = Field(
        default=8.0, gt=0, description="degrees of freedom that a location needs to be tested [1]"
    )
    significant: float = Field(
        default=0.05, gt=0, lt=1, description="p-value up to which a location is significant [1]"
    )
    least_share: float = Field(
        default=0.02, ge=0, lt=1, description="share of the excess from which a location is reported [1]"
    )
    least_order_share: float = Field(
        default=0.01,
        ge=0,
        lt=1,
        description="the same for an order, which shows only while the rotor turns [1]",
    )
    least_score: float = Field(
        default=0.02,
        ge=0,
        description="concentration from which a location is reported, so that evenly spread excess names no regime "
        "[nats]",
    )
    most: int = Field(default=12, ge=1, description="largest number of locations reported [1]")


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
    enough_level: float = Field(
        default=1e-4,
        ge=0,
        description="fall of the mean squared prediction error below which a fit ends on a real machine, whose floor "
        "is a tolerance [1]",
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
    still_falling: float = Field(
        default=0.8,
        gt=0,
        lt=1,
        description="excess over the floor after so many iterations, over that before, up to which they go on [1]",
    )
    final_iterations: int = Field(default=20, ge=1, description="iterations of the fits that are finished")


class SearchSettings(Settings):
    """Which hypotheses are fitted."""

    effects: tuple[str, ...] = Field(default=(), description="names of the effects that compete; empty: all")
    joints: tuple[str, ...] = Field(
        default=(),
        description="motors, by name or by that of their joint, at which effects compete: there, in the springs up to "
        "the next motor and in their bodies; empty or all motors: everywhere, tool, base and `all` included",
    )
    compiled: int = Field(
        default=8, ge=1, description="candidates that are compiled together: more of them predict more slowly"
    )
    steep: float = Field(
        default=0.5,
        gt=0,
        lt=1,
        description="a first fit goes on while its iterations lower the sum of squares to less than this share [1]",
    )
    settled: int = Field(
        default=3, ge=0, description="a fit that converges in so many iterations needs no second initial value"
    )
    fitted: int = Field(default=16, ge=1, description="candidates that are fitted alone, by predicted gain")
    finished: int = Field(default=6, ge=1, description="fits that are carried to their end")
    screened_values: int = Field(
        default=20_000,
        ge=100,
        description="prediction errors that gains of candidates are estimated from, spread over the log",
    )
    screened: int = Field(
        default=12, ge=1, description="candidates by predicted gain among which those are sought whose gains add up"
    )
    grouped: int = Field(default=6, ge=1, description="most candidates that are added at a time")
    kept: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="share of its own gain that a candidate must keep together with others to be added with them [1]",
    )
    kept_of_misfit: float = Field(
        default=0.05,
        gt=0,
        le=1,
        description="the same for the estimate of what no candidates remove together, on a real machine [1]",
    )
    added: int = Field(default=3, ge=1, description="candidates that are added alone as well, by predicted gain")
    most_effects: int = Field(default=30, ge=1, description="most effects in one explanation")
    rounds: int = Field(default=12, ge=1, description="most rounds of forward selection, and of exchanges")
    rounds_after_torques: int = Field(
        default=1,
        ge=0,
        description="most rounds of forward selection after friction and inertia by the torques of a real machine: "
        "further ones take long and find imitations of what no effect describes",
    )
    simple: float = Field(
        default=0.7,
        gt=0,
        le=1,
        description="predicted gain of an effect, over that of a richer one at the same location, from which on a real "
        "machine the richer one is not added [1]",
    )
    clear_in_torques: float = Field(
        default=2.0,
        ge=0,
        description="size of an effect that torques show, over its standard deviation, from which it stays [1]",
    )
    clear_asymmetry: float = Field(
        default=5.0,
        ge=0,
        description="asymmetry of friction that torques show, over its standard deviation, from which it stays [1]",
    )
    hopeful: float = Field(
        default=0.5,
        ge=0,
        description="predicted gain from which a further effect is fitted in addition to those that torques show, over "
        "what it must remove [1]: linear theory underestimates some",
    )
    resumed: int = Field(
        default=2,
        ge=0,
        description="times that the search goes on after exchanges, in simulated logs [1] (chosen)",
    )
    removed_by_step: float = Field(
        default=0.1,
        gt=0,
        lt=1,
        description="share of the remaining gap that a step of forward selection must remove, and every effect while "
        "the search goes on [1]",
    )
    curves: int = Field(
        default=3, ge=0, description="most curves without a law that are added on a real machine, the best ones"
    )
    beyond_laws: float = Field(
        default=1.5,
        ge=1,
        description="predicted gain of a curve, over that of any further law at its motor or at none, from which it is "
        "added: less is a model-form error of that law [1] (chosen)",
    )
    regained: float = Field(
        default=0.5,
        gt=0,
        description="predicted gain from which a candidate is fitted in place of an effect, over what is lost without "
        "that effect [1]",
    )
    indispensable: float = Field(
        default=0.9,
        gt=0,
        lt=1,
        description="share of the remaining gap from which an effect is not tried to be left out, by linear theory [1]",
    )
    certain: float = Field(
        default=2.5, ge=1, description="the same, over the share that an effect must remove [1]; the lower one counts"
    )
    removed: float = Field(
        default=0.4,
        gt=0,
        lt=1,
        description="share of the remaining gap that every effect must remove in the end, all others in place [1]; "
        "spurious ones remove up to 0.3 (development seeds)",
    )
    removed_of_little: float = Field(
        default=0.6,
        gt=0,
        lt=1,
        description="the same where little more than noise is left, within the model-form error of the gap: there "
        "imitations of the form removed up to 0.41 [1] (development seeds)",
    )
    removed_at_motor: float = Field(
        default=0.6,
        gt=0,
        lt=1,
        description="share of the remaining gap at one of several motors that is enough where that is little of the "
        "whole [1] (chosen)",
    )
    little: float = Field(
        default=0.2, ge=0, description="excess of the level of the prediction errors over the floor that is little [1]"
    )
    least_of_gap: float = Field(
        default=1e-7,
        ge=0,
        description="share of the gap of the nominal model that every effect must remove [1]: less is within the "
        "numerical error of the model, relative in amplitude 3e-4",
    )
    removed_of_all: float = Field(
        default=0.2,
        gt=0,
        lt=1,
        description="the same on a real machine, where what no effect explains is part of what remains [1]",
    )
    removed_of_floor: float = Field(
        default=0.3,
        ge=0,
        lt=1,
        description="share of the floor of one motor that every effect must remove on a real machine, where the floor "
        "is a stated tolerance [1]",
    )
    freed: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="share of the squared deviations of tolerated numbers, where these are beyond tolerance, that an "
        "effect must free to be part of an explanation of a real machine, however little it removes [1]",
    )
    within_floor: float = Field(
        default=0.5,
        gt=0,
        lt=1,
        description="level of the prediction errors, over that without them, up to which further effects are found "
        "below the floor of a real machine, as they are where the torques are known better than stated [1]",
    )
    tried_orders: int = Field(
        default=5, ge=1, description="orders of a rotor that are fitted: the most prominent and the largest, each"
    )
    fastest_order: float = Field(
        default=0.4, gt=0, le=0.5, description="highest frequency of an order, relative to the sampling frequency [1]"
    )


class TorqueStartSettings(Settings):
    """What the torques of a real machine show before any prediction: the regression that the search begins with."""

    least_share: float = Field(
        default=0.1,
        ge=0,
        description="contribution of friction, motor inertia or servo stiffness to a torque, over the rest at that "
        "motor, from which it is kept, rms [1] (chosen)",
    )
    most_reduced: float = Field(
        default=0.9,
        gt=0,
        lt=1,
        description="largest share of a nominal rotor inertia or servo stiffness that is taken away [1] (chosen)",
    )
    longest_delay: int = Field(
        default=10, ge=0, description="longest delay of commanded positions that is tried [samples] (chosen)"
    )
    balanced: float = Field(
        default=2.5,
        ge=1,
        description="factor by which a counterbalance lowers what is left at its motor, from which there is one [1] "
        "(chosen)",
    )
    carried: float = Field(
        default=0.5,
        ge=0,
        description="torque of a counterbalance over the largest of its motor, from which there is one [1] (chosen): "
        "it is built to carry weight. Less is an error of the weight of the arm, as on a robot whose URDF is a third "
        "too light",
    )
    least_rotor: float = Field(
        default=0.2,
        ge=0,
        description="inertia of a rotor, over that of the bodies it moves, from which the robot file lacks it [1] "
        "(chosen); less may be in that of the bodies, as for a drive whose one mass is that of all its parts",
    )
    least_stepped_rotor: float = Field(
        default=0.1,
        ge=0,
        description="inertia that a motor without rotor is given so that its friction can be stepped, over that of its "
        "bodies, from which it is [1] (chosen)",
    )
    lightest_load: float = Field(
        default=0.05,
        ge=0,
        description="mass of a load over that of all bodies that move, from which the robot file lacks it [1] (chosen)",
    )
    farthest_load: float = Field(
        default=1.0, gt=0, description="largest distance of a load from the last joint [m] (chosen)"
    )
    explained_by_load: float = Field(
        default=10.0,
        ge=1,
        description="product over the motors of the factors by which a load lowers what is left of their torques, each "
        "no larger than this, from which the robot file lacks it [1] (chosen): 1.6 on a UR10e that carries nothing, "
        "above 1000 on an arm whose tool is 7 % of its mass. So the others are not left with more where one motor has "
        "no torque, as where it is not driven: a load that takes the weight of its body away explains that",
    )
    relieved: float = Field(
        default=1.5,
        ge=1,
        description="factor by which a counterbalance alone lowers what is left at its motor, from which a load is "
        "sought together with it [1] (chosen)",
    )


class ServoStartSettings(Settings):
    """Fits of servos under position commands, from several initial values: the best one begins the search."""

    often_limited: float = Field(
        default=0.01,
        gt=0,
        lt=1,
        description="share of the samples at its torque limit from which a servo counts as one that reaches it [1] "
        "(chosen)",
    )
    friction: float = Field(
        default=0.1,
        gt=0,
        description="initial Coulomb friction of a servo at its limit, over the torque limit [1] (chosen)",
    )
    braking: float = Field(
        default=0.5,
        gt=0,
        description="initial viscous friction of a servo at its limit, at the largest speed, over the torque limit [1] "
        "(chosen): a limited voltage ends the acceleration where the back-EMF reaches it",
    )
    little_friction: float = Field(
        default=0.01,
        gt=0,
        description="initial Coulomb friction of other servos, over the largest one of its range [1] (chosen)",
    )
    undamped: float = Field(
        default=-0.85,
        gt=-1,
        lt=0,
        description="relative error of the damping of a loop that hardly brakes, a further initial value for servos at "
        "their limits [1] (chosen)",
    )
    wider: float = Field(
        default=10.0,
        ge=1,
        description="factor by which friction may exceed what the largest nominal torque overcomes, as the gains of a "
        "servo may be wrong by it [1] (chosen)",
    )
    delays: tuple[float, ...] = Field(
        default=(0.25, 1.25, 2.25, 3.25),
        min_length=1,
        description="initial delays [samples] (chosen): between whole ones, at which the prediction has a corner",
    )
    iterations: int = Field(
        default=8, ge=1, description="iterations after which the best one of the fits goes on alone (chosen)"
    )


class BristleSettings(Settings):
    """Bristles of dry friction, which yield by less than an encoder shows."""

    smallest: float = Field(
        default=1e-3,
        gt=0,
        description="smallest deflection of bristles over the noise of the encoder [1] (chosen): less acts as rigid "
        "contacts",
    )
    initial: float = Field(
        default=0.3,
        gt=0,
        description="deflection at which a fit begins, over the noise of the encoder [1] (chosen)",
    )
    relaxation: float = Field(
        default=1e-3, gt=0, description="damping over stiffness at which a fit begins [s] (chosen)"
    )
    relaxations: tuple[float, float] = Field(default=(1e-7, 1.0), description="bounds of that ratio [s] (chosen)")


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
    confirmed_share: float = Field(
        default=0.2,
        gt=0,
        lt=1,
        description="share of the gap in the held-out log from which effects that leave a rest are a part of the truth "
        "[1]",
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


class DiagnosisSettings(Settings):
    """Settings of a diagnosis."""

    level: float = Field(
        default=2e-4, gt=0, description="torque noise that the predictor allows for, relative: see `observer_gain` [1]"
    )
    fitted_share: float = Field(
        default=2 / 3, gt=0, lt=1, description="share of the log that is fitted to where there is no second one [1]"
    )
    most_values: int = Field(
        default=600_000,
        ge=1000,
        description="most samples of all motors together that are fitted or held out; of a longer log the most "
        "informative part, so that memory stays below 1.5 GB",
    )
    time_limit: float | None = Field(
        default=None,
        gt=0,
        description="time from the begin of the diagnosis after which the search ends and the best explanation so far "
        "is the answer [s]; nothing: none",
    )
    threads: int = Field(default=0, ge=0, description="fits at the same time; 0: as many as there are cores")
    seed: int = Field(default=1, ge=0, description="seed of the simulated logs without gap")
    noise: NoiseSettings = Field(default=NoiseSettings(), description="encoder noise")
    residuals: ResidualSettings = Field(default=ResidualSettings(), description="weighted prediction errors")
    where: WhereSettings | None = Field(
        default=WhereSettings(), description="locations of the gap; nothing: they are not computed"
    )
    prediction_gap: PredictionGapSettings = Field(default=PredictionGapSettings(), description="gap on held-out data")
    sensitivity: SensitivitySettings | None = Field(
        default=SensitivitySettings(),
        description="names with halved and doubled tolerances, for logs of real machines; nothing: not compared",
    )
    next_experiment: NextExperimentSettings | None = Field(
        default=NextExperimentSettings(),
        description="experiment that is proposed where the answer is ambiguous; nothing: none is",
    )
    fit: FitSettings = Field(default=FitSettings(), description="least-squares fit of one hypothesis")
    torque_start: TorqueStartSettings = Field(
        default=TorqueStartSettings(), description="what the torques of a real machine show before the search"
    )
    servo_start: ServoStartSettings = Field(
        default=ServoStartSettings(), description="fits of servos under position commands before the search"
    )
    search: SearchSettings = Field(default=SearchSettings(), description="which hypotheses are fitted")
    bristles: BristleSettings = Field(default=BristleSettings(), description="bristles of dry friction")
    ranking: RankingSettings = Field(default=RankingSettings(), description="probabilities and verdict")

    @property
    def cores(self) -> int:
        """Threads that work at the same time."""
        return self.threads or os.cpu_count() or 1
