"""The search for causes: fits of hypotheses, and which of them are fitted."""

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
    enough_level: float = Field(
        default=1e-4,
        ge=0,
        description="fall of the mean squared prediction error below which a fit ends on a real machine, whose floor "
        "is a tolerance [1]",
    )
    enough_of_rest: float = Field(
        default=1e-4,
        ge=0,
        description="fall of the sum of squares below which a fit to a simulated log ends, over what it leaves above "
        "the floor [1] (chosen): decisions ask for a tenth of that. A tenth of this share for fits that are carried to "
        "their end",
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
    valley_passes: int = Field(
        default=180,
        ge=1,
        description="predictions by which these fits may go on in simulated logs beside a nominal model with "
        "tolerances, which make long valleys [1] (chosen)",
    )


class SearchSettings(Settings):
    """Which hypotheses are fitted."""

    effects: tuple[str, ...] = Field(
        default=(), description="names of the effects that compete; empty: all but those on request"
    )
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
        default=3,
        ge=0,
        description="most rounds of forward selection after friction and inertia by the torques of a real machine: "
        "further ones take long",
    )
    removed_by_further: float = Field(
        default=0.35,
        gt=0,
        lt=1,
        description="share of the remaining gap that each of these rounds must remove but the first one [1] (chosen): "
        "imitations of what no effect describes removed up to 0.3",
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
    clear: float = Field(
        default=3.0,
        ge=0,
        description="size of an effect, over its standard deviation with errors of form, from which it stays in a "
        "simulated log although noise alone is left without it [1] (chosen: one of 400 is beyond by chance)",
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
    within_reach: float = Field(
        default=10.0,
        gt=1,
        description="sum of squares that linear theory predicts for such an exchange, over that of the explanation, up "
        "to which it is fitted [1]: of two six-axis crowds those that were any better were predicted up to 3.2 "
        "(development seeds)",
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
    removed_if_constant: float = Field(
        default=0.1,
        gt=0,
        lt=1,
        description="the same for an effect whose size is constant over a simulated log, where no explanation "
        "suffices: beside something that no effect explains, a known one removes little of the whole [1] (chosen)",
    )
    little: float = Field(
        default=0.2, ge=0, description="excess of the level of the prediction errors over the floor that is little [1]"
    )
    least_of_gap: float = Field(
        default=1e-7,
        ge=0,
        description="share of the gap that every effect must remove, less what wrong numbers of the model make of it "
        "in a simulated log [1]: less is within the numerical error of the model, relative in amplitude 3e-4",
    )
    removed_of_all: float = Field(
        default=0.2,
        gt=0,
        lt=1,
        description="the same on a real machine, where what no effect explains is part of what remains [1]",
    )
    freed: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="share of the squared deviations of tolerated numbers, where these are beyond tolerance, that an "
        "effect must free to be part of an explanation of a real machine, however little it removes [1]",
    )
    within_floor: float = Field(
        default=0.4,
        gt=0,
        lt=1,
        description="what the prediction errors have beyond the noise of sensors, over that without them, up to which "
        "further effects are found within the floors that an explanation of a real machine may leave, as they are "
        "where the torques are known better than stated [1]",
    )
    least_of_tolerance: float = Field(
        default=0.2,
        ge=0,
        description="size over that of the tolerated torques from which such an effect is one [1] (chosen): with a "
        "tolerance of 5 % of the rms torque, 1 % of it",
    )
    rounds_on_trial: int = Field(
        default=4,
        ge=0,
        description="most steps of effects that are added on trial to an explanation of a real machine: several that "
        "are missing hide each other [1] (chosen)",
    )
    least_on_trial: float = Field(
        default=0.03,
        gt=0,
        lt=1,
        description="share of what is left above the floor that each of these steps must remove there [1] (chosen): "
        "what counts is what all of them leave",
    )
    line_width: float = Field(
        default=2.0,
        gt=0,
        description="highest frequency at which amplitude and phase of the response to a line change, which a search "
        "beside it leaves out [Hz] (chosen): the pose changes them, as fast as the robot moves",
    )
    line_share: float = Field(
        default=0.5,
        gt=0,
        lt=1,
        description="share of what is left that must be near a line, and of that in the line itself, for a search "
        "beside it [1] (chosen)",
    )
    line_itself: float = Field(
        default=0.125, gt=0, lt=1, description="distance from a line that counts as the line itself, over the width [1]"
    )
    tried_orders: int = Field(
        default=5, ge=1, description="largest orders of a rotor that are fitted, for each of three sizes of the noise"
    )
    fastest_order: float = Field(
        default=0.4,
        gt=0,
        le=0.5,
        description="highest frequency of an order in half of the motion over that of sampling [1]",
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
