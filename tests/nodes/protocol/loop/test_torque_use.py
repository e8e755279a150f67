"""Use of the torque limits by commands."""

from __future__ import annotations

import numpy as np
import pytest

from flexros_nodes.protocol.loop.torque_use import BATCH, TorqueUse


@pytest.mark.parametrize("samples", [5, BATCH, 2 * BATCH + 3])
def test_peak_and_samples_at_the_limit_are_counted(samples: int) -> None:
    use = TorqueUse(["a", "b"], np.array([10.0, 4.0]))
    for _ in range(samples - 2):
        use.add(np.array([2.0, 1.0]))
    use.add(np.array([-7.5, -4.0]))
    use.add(np.array([0.0, 4.0 * (1 - 1e-12)]))  # cut off by a controller that rounds
    assert use.figures() == {
        "a.largest_share_of_torque_limit": 0.75,
        "a.samples_at_torque_limit": 0,
        "b.largest_share_of_torque_limit": 1.0,
        "b.samples_at_torque_limit": 2,
    }
    assert use.figures() == use.figures()  # asking changes nothing


def test_motor_without_limit_has_no_figures() -> None:
    use = TorqueUse(["a", "b"], np.array([np.inf, 4.0]))
    use.add(np.array([1e9, 1.0]))
    assert set(use.figures()) == {"b.largest_share_of_torque_limit", "b.samples_at_torque_limit"}


def test_before_the_first_command_nothing_is_used() -> None:
    assert TorqueUse(["a"], np.array([1.0])).figures() == {
        "a.largest_share_of_torque_limit": 0.0,
        "a.samples_at_torque_limit": 0,
    }
