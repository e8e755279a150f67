"""What an explanation leaves in the rest of long logs, of which a part was used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.gap.answer.decision import level_of_positions
from flexros.gap.noise.weights import measurement_in
from flexros.gap.residuals.prepare_fit_data import fit_data

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.null_fit import NullFit
    from flexros.record.record import Record

CHANGED = 3.0
"""What is left of a piece over what is left of the part that is used, and may be left, from which it is another one [1]
(chosen)."""


def changes_over_log(pieces: Sequence[Record], fit: CandidateFit, null: NullFit) -> list[str]:
    """Say where an explanation leaves much more of a log than in the part that is used.

    Something changed then that the part does not show, as a temperature. The explanation is weighed one sample ahead,
    in pieces that are tied as that part.

    Args:
        pieces: Pieces of the rest of the logs.
        fit: The explanation.
        null: The nominal model, fitted to the part that is used.
    """
    data, robot = null.data, null.model.robot
    settings, used = data.settings, level_of_positions(fit, data)
    found = []
    for piece in pieces:
        measurement = measurement_in(piece, robot, data.measurement, settings)
        around = fit.predictor, fit.theta
        try:
            level = level_of_positions(
                fit, fit_data(piece, null.model, settings, measurement, data.torque_noise, around)
            )
        except InputError:  # it is too short for the prediction to settle
            continue
        if level > CHANGED * max(used, settings.ranking.floors):
            found.append(f"{level:.3g} from {piece.begin:.4g} to {piece.begin + piece.duration:.4g} s")
    if not found:
        return []
    return [
        f"what is left one sample ahead changes over the log: {used:.3g} floors in the part that is used, but "
        f"{', '.join(found)}; what changed there, as a temperature, a load or a contact, is not in the answer: cut the "
        "log there and diagnose that part as well"
    ]
