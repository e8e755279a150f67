"""Commands whose names say no quantity, told by their values."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.proposal.unnamed_commands import UnnamedCommands

_TIME = np.linspace(0, 5, 500)
_POSITIONS = (np.sin(_TIME), 1.5 + 0.2 * np.cos(_TIME))


@pytest.mark.parametrize(
    ("commands", "quantity", "clear"),
    [
        ((np.sin(_TIME + 0.1), _POSITIONS[1] + 0.1), "position", True),  # late, and sagging
        ((0 * _TIME, 30 + 0 * _TIME), "torque", True),
        ((0.01 * np.cos(_TIME), 0.02 * np.sin(_TIME)), "torque", True),  # of a light arm
        ((0.6 * _POSITIONS[0], 0.6 * _POSITIONS[1]), "position", False),
    ],
)
def test_commands_near_the_positions_are_positions(
    commands: tuple[np.ndarray, np.ndarray], quantity: str, clear: bool
) -> None:
    found = UnnamedCommands.of(commands, _POSITIONS)
    assert (found.quantity, found.clear) == (quantity, clear)


def test_lost_samples_count_for_nothing() -> None:
    lost = np.where(_TIME > 4, np.nan, _POSITIONS[0])
    assert UnnamedCommands.of([lost], _POSITIONS[:1]).distance == 0.0
