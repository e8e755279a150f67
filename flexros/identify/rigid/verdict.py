"""Verdict on a rigid fit: usable for a robot file or not, in one sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.identify.rigid.fit import LARGEST_ERROR
from flexros.identify.rigid.identified_robot import IdentifiedRobot, identified_values

if TYPE_CHECKING:
    from flexros.identify.rigid.fit import RigidFit

_MOST_MISSED = 0.5
"""Largest share of estimated base parameters that no feasible robot attains for which a file is written (chosen)."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """Verdict on a fit.

    Attributes:
        usable: Whether the fit explains the torque well enough, and a physically feasible robot does so, too.
        sentence: The verdict as a sentence.
        identified: The feasible robot; without values when the fit itself is not usable.
        file_error: Unexplained share of the torque with the values of the robot file [%]; None without a search.
    """

    usable: bool
    sentence: str
    identified: IdentifiedRobot
    file_error: float | None


def judge_fit(fit: RigidFit) -> Verdict:
    """Judge a fit by its unexplained torque, and search a physically feasible robot if it is good enough.

    The search takes at most as many rounds as the robot has bodies and motors, as each round leaves another one of them
    at its nominal values.
    """
    if fit.error.total > LARGEST_ERROR:
        return Verdict(
            False,
            f"the rigid model leaves {fit.error.total:.3g} % of the torque unexplained, more than {LARGEST_ERROR:g} %: "
            f"{_reason(fit)}",
            IdentifiedRobot({}, {}, {}, fit.base.nominal),
            None,
        )
    identified = identified_values(fit)
    error = fit.force_error(identified.base_values)
    estimated, missed = len(fit.excitation.shown), len(identified.not_met)
    if error > LARGEST_ERROR or missed > _MOST_MISSED * estimated:
        return Verdict(
            False,
            f"the rigid model leaves {fit.error.total:.3g} % of the torque unexplained, but with infeasible values "
            f"(the nearest feasible robot misses {missed} of {estimated} and leaves {error:.3g} %): "
            f"{_reason(fit)}",
            identified,
            error,
        )
    sentence = f"the rigid model leaves {fit.error.total:.3g} % of the torque unexplained"
    if identified.not_met:
        sentence += f", the robot file {error:.3g} %, since not all identified values are feasible"
    return Verdict(True, sentence, identified, error)


def _reason(fit: RigidFit) -> str:
    """State the most likely cause and the remedy."""
    if fit.error_with_hold is not None and fit.error_with_hold < min(LARGEST_ERROR, fit.error.total):
        return (
            f"with delay and hold of the command it would be {fit.error_with_hold:.3g} %; pair positions with the "
            "command as it acts (setting hold)"
        )
    if fit.other_cutoff is not None:
        cutoff, error = fit.other_cutoff
        why = "what is left is fast, as the noise of a coarse encoder or a part that bends"
        if cutoff > fit.cutoff:
            why = "the motors move faster than that"
        return (
            f"with a cut-off of {cutoff:.3g} Hz instead of {fit.cutoff:.3g} Hz it would be {error:.3g} %: {why} "
            "(setting cutoff)"
        )
    if fit.robot.n_coordinates > fit.robot.n_motors:
        return "the motion excites the flexibilities or shows too little; record slow moves"
    return "the log contains torques that are not in the model; check robot and units, and record moves without contact"
