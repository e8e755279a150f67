"""Places of a gap: the joint, and the side of its gear."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.logs.time_series import Log
from flexros.monitor.disturbance_location import DisturbanceLocation, LocationGain, close, locations_of
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.watch import Watch
from flexros.monitor.watch_log import watch_log


def told(log: Log, robot: str) -> tuple[str, str]:
    found = watch_log(log, GapMonitor(load_model(robot)), name="log")
    assert found.episodes
    kinds = Counter((one.kind, one.joint) for one in found.episodes)
    return kinds.most_common(1)[0][0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "effect", "kind", "joint"),
    [
        ("elbow", "coulomb_friction@motor_1:level=3", "motor", "motor_1"),
        ("elbow", "coulomb_friction@motor_2:level=3", "motor", "motor_2"),
        ("elbow", "payload_error@tool:relative=0.05", "tool", "tool"),
        ("four_mass_linear", "coulomb_friction@motor_1:level=0.02", "motor", "motor_1"),
        ("four_mass_linear", "backlash@motor_1:gap=1e-3", "gear", "motor_1"),
        ("e12", "coulomb_friction@motor_2:level=3", "motor", "motor_2"),
    ],
)
def test_effects_are_told_at_their_place(
    robot: str, effect: str, kind: str, joint: str, make_log: Callable[..., Log]
) -> None:
    assert told(make_log(robot, effect), robot) == (kind, joint)


def test_places_of_an_elastic_robot() -> None:
    model = load_model("elbow")
    places = locations_of(model.robot, Watch(model, 5e-4, 200).book.at((0, 0)).design)
    assert [(place.kind, place.joint) for place in places] == [
        *((kind, joint) for joint in ("motor_1", "motor_2") for kind in ("motor", "gear", "arm")),
        ("tool", "tool"),
    ]
    gear = places[1].force
    assert gear.sum() == pytest.approx(0.0, abs=1e-9)  # it pushes motor and arm apart


def test_a_rigid_drive_has_its_motor_and_its_tool_alone() -> None:
    model = load_model("emps")
    places = locations_of(model.robot, Watch(model, 1e-3, 100).book.at((0,)).design)
    assert {place.kind for place in places} <= {"motor", "tool"}


def test_places_that_come_close_are_kept() -> None:
    def suspicion(joint: str, lines: np.ndarray) -> LocationGain:
        return LocationGain(DisturbanceLocation("motor", joint, np.ones((1, 1))), float(lines.sum()), lines)

    first = suspicion("motor_1", np.full(100, 10.0))
    scattered = np.where(np.arange(100) % 2, 14.9, 5.0)
    others = [
        suspicion("motor_2", np.full(100, 9.9)),
        suspicion("motor_3", scattered),
        suspicion("motor_4", 0.5 * scattered),
    ]
    assert [one.location.joint for one in close([first, *others])] == ["motor_1", "motor_3"]
