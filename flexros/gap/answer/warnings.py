"""What is doubtful about an answer: warnings of the logs, of the sensors, and of what was found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.torque_drift import TorqueDrift
from flexros.gap.answer.hanging_sizes import hanging_sizes
from flexros.gap.answer.strained_numbers import moved_words, strained_numbers
from flexros.gap.answer.unexplained_torques import torque_warnings
from flexros.gap.fit.estimates import placed_effects
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import tolerance_floor
from flexros.gap.held_out.sensor_scales import sensor_scale_words
from flexros.gap.search.better_torques import LEAST
from flexros.record.one_way import ONE_WAY, moves_one_way

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings
    from flexros.gap.schema import GapNumbers
    from flexros.record.record import Record

LOW_FRACTION, LEAST_GAP = 0.5, 2.0
"""Closed fraction below which, and gap above which, it is warned that the explanation may not hold elsewhere [1]."""

SIZEABLE, LEAST_FLOOR = 0.25, 2.0
"""Share of the gap that the tolerance of torques makes from which what is left is about that, and the least such gap
[1] (chosen)."""

SCALED, SEVERAL = 0.3, 2
"""Size of an error of the torque gain, and number of motors that have one, from which a wrong unit is likelier than
such drives [1] (chosen): torque constants drop by 10 % when hot."""

MUCH_MORE = 4.0
"""Gap of the held-out log over that of its torques in tolerance, from which the other log may show more [1] (chosen):
twice that is allowed."""

CONSTANT_ONE_WAY = ("coulomb_friction", "torque_bias")
"""Effects that are one constant torque at a motor that moves in one direction only."""

CHECK_AGAIN = "what it stood for is not known; that log took part in the choice, so check the patch on a third"
"""What follows where the held-out log took an effect out of the explanation."""

STANDS = 0.02
"""Step of a position over its median, up to which a motor stands [1] (chosen); there friction balances what acts."""


def record_warnings(fitted: Record, held: Record) -> tuple[str, ...]:
    """Return the warnings of the fitted log, and those that only the held-out one has."""
    return (*fitted.warnings, *(f"held-out log: {text}" for text in held.warnings if text not in fitted.warnings))


def sensor_warnings(findings: Findings) -> tuple[str, ...]:
    """Return the warnings of encoders, tool tracker and further sensors."""
    data = findings.data
    of_tool = () if data.tool is None else data.tool.warnings
    return (*data.measurement.warnings, *of_tool, *sensor_scale_words(findings.repaired, data))


def answer_warnings(findings: Findings, gap: GapNumbers, *, worse: bool) -> list[str]:
    """Return what limits the answer."""
    explanations, remainder, warnings = findings.explanations, findings.explanations.remainder, []
    if explanations.detected and remainder > 0 and explanations.comparison.adequate(explanations.chosen):
        warnings.append(
            f"the explanation leaves {100 * remainder:.2g} % of the gap in the fitted log, more than noise does"
        )
    if worse:
        warnings.append(
            "the explanation predicts the held-out log worse than the nominal model, so there is no patch: that log "
            "may be of other conditions, or what acts is not among the effects"
        )
    elif gap.closed_fraction is not None and gap.closed_fraction < LOW_FRACTION and gap.before > LEAST_GAP:
        warnings.append(
            f"on held-out data the explanation closes only {100 * gap.closed_fraction:.0f} % of the gap: it may not "
            "hold beyond the fitted log"
        )
    warnings += _taken_out(findings)
    warnings += _within_tolerance(findings, gap)
    warnings += _less_excited(findings, gap)
    warnings += _hopeless_as_given(findings)
    return [
        *torque_warnings(findings),
        *_strained(findings),
        *warnings,
        *_without_finding(findings),
        *_unusual(findings, gap),
        *_unit_warnings(findings),
        *_drift_warnings(findings),
        *_one_way_warnings(findings),
        *hanging_sizes(findings),
    ]


def _taken_out(findings: Findings) -> list[str]:
    """Return one sentence for every effect that the held-out log took out of the explanation."""
    return [
        *(
            f"{name} explains a part of the fitted log, but the held-out log does not confirm it: it was withdrawn, "
            f"and {CHECK_AGAIN}"
            for name in findings.withdrawn
        ),
        *(
            f"the size of {name} ended at the last limit of its search, which is no finding: the held-out log is "
            f"predicted better by what was fitted again without it, and {CHECK_AGAIN}"
            for name in findings.fitted_around
        ),
    ]


def _hopeless_as_given(findings: Findings) -> list[str]:
    """Return one sentence where the model predicts nothing without what it lacks, so that the gap is that with it."""
    kept = findings.as_given.kept if findings.explanations.detected else ()
    if not kept:
        return []
    return [
        f"the nominal model lacks {', '.join(sorted(kept))}, without which it predicts 0.1 s ahead hardly better than "
        "that all motors stay where they are: the gap before the repair is that of the model with them"
    ]


def _within_tolerance(findings: Findings, gap: GapNumbers) -> list[str]:
    """Say where what is left is about what the tolerance of torques allows for: effects below that do not show.

    A smaller one is proposed down to the smallest on trial.
    """
    share, floor = findings.data.measurement.signal_tolerance, gap.tolerance_floor
    if gap.after is None or floor is None or floor < LEAST_FLOOR or not SIZEABLE < gap.after / floor < 1 / SIZEABLE:
        return []
    known_better = (
        f": if these torques are known better, as those of a simulator, state a tolerance of torque of {LEAST:g}"
    )
    return [
        f"what is left is about what torques that are off by {100 * share:g} % of their rms leave, and effects below "
        f"that do not show{known_better if share > LEAST else ''}"
    ]


def _less_excited(findings: Findings, gap: GapNumbers) -> list[str]:
    """Say where the fitted log is explained and the held-out one is not, which may show more of the robot."""
    chosen, data, floor = findings.explanations.chosen, findings.data, gap.tolerance_floor
    if data.record.premises.floor_is_noise or _continues(findings) or gap.after is None or floor is None:
        return []
    within = findings.settings.floors * (tolerance_floor(chosen, data) or 1.0)
    if gap.after < MUCH_MORE * floor or errors_ahead(chosen, data).mean > within:
        return []
    return [
        "the fitted log is explained within the tolerance of its torques and the held-out log is not: it may excite "
        "more, so exchange the two and compare the answers"
    ]


def _continues(findings: Findings) -> bool:
    """Return whether the held-out log is the rest of the fitted one."""
    fitted, held = findings.data.record, findings.held.record
    return held.begin >= fitted.begin + (fitted.n_samples - 1) * fitted.sample_time


def _without_finding(findings: Findings) -> list[str]:
    """Return one sentence for every effect whose size ended at the limit of its search.

    A gain that leaves next to nothing of a torque says that it is not the torque of that motion.
    """
    lost = {
        f"{one.effect.name}@{one.location}"
        for one in placed_effects(findings.explanations.chosen)
        if isinstance(one.effect, AbstractCommandLaw) and one.effect.gain < 1
    }
    return [
        f"the torque of {name.partition('@')[2]} in the log does not explain its motion: predictions are better the "
        "less of it acts. It is not the torque of this motor, or its unit is another one; no gain of it is a finding, "
        "and none is in the patch"
        if name in lost
        else f"the size of {name} ended at the limit of its search, which is no finding: it is not in the patch"
        for name in sorted(findings.beyond_search)
    ]


def _strained(findings: Findings) -> list[str]:
    """State the numbers of the model that the answer moves far out of their tolerance."""
    factors = strained_numbers(findings)
    if not factors:
        return []
    moved = moved_words(findings.explanations.chosen, factors)
    found = findings.explanations.detected
    held = " A patch has them but for those that no effect changes, such as lengths." if found else ""
    return [
        f"the answer moves numbers of the model beyond their tolerance: {moved}.{held} They may stand "
        "for an effect such as a load: measure them, or correct them in the robot file"
    ]


def _unusual(findings: Findings, gap: GapNumbers) -> list[str]:
    """Return one sentence for every effect of a size that it hardly ever has, with what is likelier.

    What is left of the held-out gap tells which: with a number of the robot file that is wrong all of it is explained.
    """
    found = [(one, one.effect.stands_for()) for one in placed_effects(findings.explanations.chosen)]
    most = findings.settings.floors * (gap.tolerance_floor or 1.0)
    left = ". What is left speaks for the latter" if gap.after is not None and gap.after > most else ""
    return [f"{one.effect.name}@{one.location} {text}{left}" for one, text in found if text]


def _unit_warnings(findings: Findings) -> list[str]:
    """Warn where the torques of several motors of an imported log act as if they had another unit."""
    scaled = [
        one
        for one in placed_effects(findings.explanations.chosen)
        if isinstance(one.effect, AbstractCommandLaw) and abs(one.effect.gain - 1) > SCALED
    ]
    record = findings.data.record
    if len(scaled) < SEVERAL or not record.imported or record.command is not None:
        return []
    motors = findings.model.robot.motors
    limits = [motors[findings.model.robot.joint_names.index(one.location)].torque_limit for one in scaled]
    factors = ", ".join(
        f"{one.location}: {one.effect.gain:.3g}" + (f" with a limit of {limit:g}" if np.isfinite(limit) else "")
        for one, limit in zip(scaled, limits)
        if isinstance(one.effect, AbstractCommandLaw)
    )
    return [
        f"the recorded torques act by other factors ({factors}): a wrong unit, as per cent of a rated torque or a "
        "current, torque constant or gear ratio in the mapping is likelier than such drives; import again with scale"
    ]


def _drift_warnings(findings: Findings) -> list[str]:
    """Return one sentence for every curve over time: of another start it says nothing.

    A held-out part that continues the fitted log is predicted with the last value of the curve, another log as if the
    curve repeated from its start on; so is every run of the patch.

    Args:
        findings: Fits of one log, and what the held-out log says of them.
    """
    continues = _continues(findings)
    how = "the held-out part is predicted with its last value" if continues else "the held-out log as if it repeated"
    drifts = [one for one in placed_effects(findings.explanations.chosen) if isinstance(one.effect, TorqueDrift)]
    return [
        f"the {one.effect.words} at {one.location} is that of the fitted log, {one.effect.begin:.3g} to "
        f"{one.effect.end:.3g} s after its start; {how}. Of another start it says nothing: where it does not repeat, "
        f"put torque_bias@{one.location} into the patch instead"
        for one in drifts
        if isinstance(one.effect, TorqueDrift)
    ]


def _one_way_warnings(findings: Findings) -> list[str]:
    """Return one sentence for every constant torque at a motor that moves in one direction and does not stand."""
    record, texts = findings.data.record, []
    for one in placed_effects(findings.explanations.chosen):
        if one.effect.name not in CONSTANT_ONE_WAY:
            continue
        motor = findings.model.robot.joint_names.index(one.location)
        steps = np.diff(record.position[record.valid, motor])
        stands = np.mean(np.abs(steps) <= STANDS * np.median(np.abs(steps)))
        if moves_one_way(record, motor) and stands < 1 - ONE_WAY:
            texts.append(
                f"{one.location} moves in one direction only, where Coulomb friction and a bias of the torque are one "
                f"constant torque: {one.effect.name}@{one.location} stands for both; a log with both directions tells "
                "them apart"
            )
    return texts
