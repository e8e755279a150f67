"""Where the search begins for servos under position commands: gains, limits, friction, inertia and delay at once."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.delay import Delay
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.effects.servos import ServoCommandLag
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.competitors import competitors
from flexros.gap.candidates.scales import scales_of_motors
from flexros.gap.fit.candidate_fit import first_parameters
from flexros.gap.search.servos.braking import braking_of, freed, named, restated
from flexros.gap.search.servos.fits import ServoFits, promising
from flexros.gap.search.servos.plan import CARRIED, begun_of, limited_servos, moved_from_zero, starts

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.search.servos.plan import Begun, Start
    from flexros.gap.settings import DiagnosisSettings

FILTERS = 2
"""Filters of commands from which one delay is tried in place of all (chosen)."""


def fit_of_servos(
    null: NullFit,
    regressed: CandidateFit | None,
    settings: DiagnosisSettings,
    stop: Callable[[], bool] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> CandidateFit | None:
    """Fit all numbers of servos from several starts.

    The torques of servos are computed from positions, so that a regression of them is one with errors on both sides: it
    makes gains too small, and damping with them. Gains mostly are near those of the model, so the fits also begin
    there. At its limit a servo does not act in proportion to its gains: there the limit is fitted too. Limit and torque
    constant scale the torque alike; both are named `torque_gain_error`. The back-EMF of a hobby servo brakes at the
    limit too, where the damping of the loop has no part: it is viscous friction, and the loop may have hardly any
    damping. A filter of the commands makes a motor late as a delay does; each is tried in place of the other, and both
    together: the search adds one effect at a time, and would not come from a delay to filters at all motors.

    From every start few iterations are made, with tolerated numbers at their nominal values; then the best fits of each
    list of effects go on. Friction, rotors and delays are fitted from zero on, not by their logarithms: where wrong
    gains have stood for a rotor, it comes back once these are right.

    What a load or a counterbalance does that the robot file leaves out, wrong rotors, gains and filters may do nearly
    as well: where one removes a good part of what the best fit leaves, all begin again with it.

    Args:
        null: The nominal model, fitted.
        regressed: The nominal model with what a regression of the torques shows; None without one.
        settings: Settings of the diagnosis.
        stop: Asked after each iteration; True ends the fits where they are, and no further start is fitted.
        progress: Called with "servos" and the share of the starts that are done.

    Returns:
        The best one of the fits that begin with the nominal gains and with those of the regression, and with several
        delays or with filters of the commands; of servos at their limits also without damping. None for logs of
        torques, behind springs, and for a simulated log near its model.
    """
    robot, record = null.model.robot, null.data.record
    far_off = null.data.nominal_level > settings.residuals.far_off
    if record.command is None or robot.flexible_motors or not (record.premises.torques_tell or far_off):
        return None
    begin = settings.servo_start
    limited = limited_servos(robot, record, begin.often_limited)
    competing = competitors(robot, settings.search, null.data.record.prescribed)
    listed = [pair for pair in begun_of(null, limited, begin) if competing.contain(pair[0])]
    carried = [pair for pair in listed if pair[0].effect in CARRIED]
    bare = moved_from_zero([pair for pair in listed if pair[0].effect not in CARRIED], record, robot)
    if not any(pair[0].effect is not ServoCommandLag for pair in bare):
        return None
    plan = partial(
        starts,
        delays=[delay * record.sample_time for delay in begin.delays],
        first={} if regressed is None else first_parameters(regressed),
        robot=robot,
        undamped=begin.undamped if limited.any() else None,
    )
    best = _best(ServoFits(null, settings, stop, progress), plan, bare, carried)
    if best is None:
        return None
    as_listed = {one.name: one for one, _ in listed}
    values = zip(best.hypothesis, best.predictor.values(best.theta), strict=True)
    return restated(best, [(as_listed.get(one.name, one), own) for one, own in values], null)


def _best(
    fits: ServoFits,
    plan: Callable[[Begun], list[Start]],
    bare: Begun,
    carried: Begun,
) -> CandidateFit | None:
    """Return the best fit from all starts; None where the time was over before the first.

    Args:
        fits: Fits of the log.
        plan: Lists the starts with some effects.
        bare: All effects but those of the weight that is carried, with their initial values.
        carried: Those: a load and counterbalances that the robot file leaves out; empty where none is sought.
    """
    found = fits.every(plan(bare), fits.screened, 0.0, 0.3 if carried else 0.6)
    if carried and found and not fits.over:
        found = _with_carried(fits, found, plan, bare, carried)
    if not found or fits.over:
        return fits.likeliest(found)
    best_ones = promising(found, fits.settings.servo_start.promising)
    best = fits.likeliest(fits.every([(one,) for one in best_ones], fits.longer, 0.6, 1.0))
    if best is None or fits.over:
        return best
    best = fits.longer(best, fits.settings.fit.final_iterations)
    best = best if fits.over else _with_one_delay(fits, best, bare)
    return best if fits.over else _with_less_damping(fits, best)


def _with_one_delay(fits: ServoFits, best: CandidateFit, bare: Begun) -> CandidateFit:
    """Return a fit with one delay of all commands in place of the filters of several motors, where that does as well.

    A filter makes a motor late as the delay does, and as its rotor does where the servo brakes far more than it pulls.
    The fit with all of these ends in a long valley: six filters stood for half of the delay and for three rotors.

    Args:
        fits: Fits of the log.
        best: The fit.
        bare: All effects that fits begin with, with their initial values.
    """
    stated = list(zip(best.hypothesis, best.predictor.values(best.theta), strict=True))
    lags = [own[one.free[0].name] for one, own in stated if one.effect is ServoCommandLag]
    delay = next((one for one, _ in bare if one.name == f"{Delay.name}@all"), None)
    if len(lags) < FILTERS or delay is None:
        return best
    late = first_parameters(best).get(delay.name, 0.0) + float(np.mean(lags))
    rest = [(one, own) for one, own in stated if one.effect is not ServoCommandLag and one.name != delay.name]
    begun = restated(best, [*rest, (delay, {delay.free[0].name: late})], fits.null)
    return fits.likeliest([best, fits.longer(begun, fits.settings.fit.final_iterations)]) or best


def _with_less_damping(fits: ServoFits, best: CandidateFit) -> CandidateFit:
    """Return a fit with less damping of servos than in the robot file at motors that it leaves no viscous friction.

    Both brake alike. So the damping is no number of the fits from all starts, and is taken away only where friction,
    which is never negative, does not suffice.

    Args:
        fits: Fits of the log.
        best: The fit.
    """
    null, robot = fits.null, fits.null.model.robot
    candidates = list_candidates(robot, scales_of_motors(robot, null.data.record), measured=True, known=null.model.laws)
    competing = competitors(robot, fits.settings.search, null.data.record.prescribed)
    braking = braking_of([one for one in candidates if competing.contain(one)], robot)
    free = freed(best, braking, null)
    if free is best:
        return best
    less = named(fits.longer(free, fits.settings.fit.final_iterations), braking, null)
    return less if less.chi2 < best.chi2 else best


def _with_carried(
    fits: ServoFits,
    found: list[CandidateFit],
    plan: Callable[[Begun], list[Start]],
    bare: Begun,
    carried: Begun,
) -> list[CandidateFit]:
    """Return the fits from all starts with what changes the weight that servos carry, or those found, without it.

    Each such effect is tried with the best fit, which goes on before: what few iterations leave may hide what it does.
    The best one stays, and the others are tried beside it. Within the floor, which counts what tolerances allow for,
    wrong gains and inertias stand for a load: there it must remove a good part of all that is left. Counterbalances are
    not sought there: one at every joint took up what wrong gains and rotors left on their way.

    Args:
        fits: Fits of the log.
        found: Fits from all starts without any.
        plan: Lists the starts with some effects.
        bare: These effects.
        carried: The effects of the weight, with their initial values.
    """
    first = fits.likeliest(found)
    if first is None:
        return found

    def carried_on(begun: Begun, values: Mapping[str, float]) -> CandidateFit:
        return fits.longer(fits.screened(begun, values))

    best = fits.longer(first)
    own = [pair for pair in bare if pair[0].name in best.names]
    taken: list[tuple[Candidate, float]] = []
    settings, rest = fits.settings.search, list(carried)
    while not fits.over:
        left = best.chi2 - fits.null.data.n_values
        rest = [pair for pair in rest if left > 0 or pair[0].effect is ToolLoad]
        if not rest:
            break
        tried = fits.every([([*own, *taken, pair], first_parameters(best)) for pair in rest], carried_on, 0.3, 0.3)
        index = min(range(len(tried)), key=lambda number: tried[number].chi2)
        least = settings.removed_of_all * left if left > 0 else settings.removed * best.chi2  # within the floor
        if not best.chi2 - tried[index].chi2 > least:
            break
        best = tried[index]
        taken.append(rest.pop(index))
    if taken:
        return [best, *fits.every(plan([*bare, *taken]), fits.screened, 0.3, 0.6)]
    return [best if one is first else one for one in found]
