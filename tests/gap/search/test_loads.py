"""Loads that a robot file lacks, and what stands for them in a measured log."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings, NoiseSettings, SearchSettings
from flexros.random_streams import generator
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from flexros.simulate.plant import Plant

pytestmark = pytest.mark.slow

T = 4e-3
FRICTION = ("coulomb_friction@motor_1:level=6", "coulomb_friction@motor_2:level=5")
RIVALS = (
    *("coulomb_friction", "viscous_friction", "torque_bias", "motor_inertia_error", "torque_gain_error"),
    *("payload_error", "tool_load", "gravity_error", "stiffness_error", "extra_mode"),
)
BEHIND_SPRINGS = (
    *("coulomb_friction", "viscous_friction", "motor_inertia_error", "stiffness_error", "backlash", "extra_mode"),
    *("tool_load", "payload_error"),
)


def robot_of(name: str, *directions: dict[str, Any], length: float) -> Robot:
    """Make a robot of two bodies of 10 and 5 kg whose numbers are exact."""
    bodies = [
        {
            "mass": mass,
            "center_of_mass": [0, 0, 0.5 * length],
            "inertia": {"xx": 0.05 * mass, "yy": 0.05 * mass, "zz": 0.02 * mass},
            "length": [0, 0, length],
            "directions": direction,
        }
        for mass, direction in zip((10, 5), directions, strict=True)
    ]
    coordinates = [f"body_{k}.{next(iter(one))}" for k, one in enumerate(directions, start=1)]
    data = {
        "name": name,
        "gravity": [0, 0, -9.81],
        "sample_time": T,
        "bodies": bodies,
        "outputs": {"joints": {"coordinates": coordinates}},
        "controlled": "joints",
    }
    return robot_from_data(data, f"{name}.yaml")


@cache
def gantry() -> Robot:
    """A slide and a lift."""
    motors = ({"inertia": inertia, "viscous_friction": 40.0} for inertia in (15.0, 8.0))
    slide, lift = ({axis: {"spring": "rigid", "motor": motor}} for axis, motor in zip(("tx", "tz"), motors))
    return robot_of("gantry", slide, lift, length=0.2)


@cache
def elastic_arm() -> Robot:
    """A shoulder and an elbow behind springs."""
    drives = ((20_000.0, 15.0, 4.0), (8_000.0, 6.0, 1.5))
    joints = [
        {"ry": {"spring": spring, "damper": damper, "motor": {"inertia": inertia, "viscous_friction": 8.0}}}
        for spring, damper, inertia in drives
    ]
    return robot_of("elastic_arm", *joints, length=0.4)


def measured(
    robot: Robot, *effects: str, gain: tuple[float, float], shaken: float = 0.0, seconds: float = 20.0
) -> Record:
    """Let PD controllers of some stiffness follow slow sines, and record it as another program would."""
    placed = place_effects(robot, [parse_effect(text, "test") for text in effects])
    n, random = round(seconds / T), generator(3, 700)
    time = T * np.arange(n)
    wanted = np.stack([0.4 * np.sin(2 * np.pi * 0.31 * time), 0.3 * np.sin(2 * np.pi * 0.53 * time)], axis=-1)
    wanted += 0.1 * np.sin(2 * np.pi * np.array([1.1, 1.7]) * time[:, None])
    stiffness, damping = gain
    plant = Plant(placed.robot, T, placed.robot.equilibrium(wanted[0]), substeps=8, laws=placed.laws)
    position, torque = np.empty((n, 2)), np.empty((n, 2))
    lines = np.arange(4.0, 30, 1.7)
    angles = 2 * np.pi * lines * time[:, None] + random.uniform(0, 2 * np.pi, (2, 1, len(lines)))
    shaking = shaken * np.sin(angles).sum(axis=2).T
    before = plant.measure()
    for k, command in enumerate(wanted):
        position[k] = plant.measure()
        torque[k] = shaking[k] + stiffness * (command - position[k]) - damping * (position[k] - before) / T
        before = position[k]
        plant.advance(torque[k])
    position += 2e-6 * random.standard_normal(position.shape)
    return Record("log", T, position, torque, np.ones(n, dtype=bool), imported=True)


def sizes_of(record: Record, robot: Robot, rivals: tuple[str, ...] = RIVALS) -> dict[str, dict[str, float]]:
    """Diagnose a log with a tolerance of the torques that is stated, so that no smaller one is tried."""
    noise, search = NoiseSettings(signal_tolerance=0.05), SearchSettings(effects=rivals)
    settings = DiagnosisSettings(where=None, next_experiment=None, noise=noise, search=search)
    found = diagnose(record, RobotWithEffects(robot, ()), settings=settings)
    return {
        f"{one.effect}@{one.location}": {name: size.value for name, size in one.parameters.items()}
        for one in found.diagnosis.causes
    }


def test_a_payload_takes_the_place_of_rotors_and_a_weight_that_stand_for_it() -> None:
    record = measured(gantry(), "payload_error@tool:relative=0.4", *FRICTION, gain=(2e4, 800.0))
    sizes = sizes_of(record, gantry())
    assert sizes.keys() == {"payload_error@tool", *(one.partition(":")[0] for one in FRICTION)}
    assert sizes["payload_error@tool"]["relative"] == pytest.approx(0.4, rel=0.03)


def test_a_load_behind_springs_is_found_with_its_place() -> None:
    hidden = ("tool_load@tool:mass=3,x=0.3,z=0.1", "stiffness_error@body_2.ry:relative=0.3")
    record = measured(elastic_arm(), *hidden, *FRICTION, gain=(3e3, 100.0), shaken=10.0)
    sizes = sizes_of(record, elastic_arm())
    assert sizes.keys() == {one.partition(":")[0] for one in (*hidden, *FRICTION)}
    assert sizes["tool_load@tool"]["mass"] == pytest.approx(3, rel=0.05)
    assert sizes["tool_load@tool"]["x"] == pytest.approx(0.3, rel=0.05)


@pytest.mark.parametrize(("load", "seconds"), [
    pytest.param(("tool_load@tool:mass=2,x=0.1,z=0.1",), 20.0, id="beside a load"),
    pytest.param((), 12.0, id="where a mode at the base stands for the spring"),
])  # fmt: skip
def test_effects_behind_springs_that_hide_each_other_are_found(load: tuple[str, ...], seconds: float) -> None:
    """Backlash alone removes a sixth and less of what the others leave; its size must be right for those of others."""
    spring, rotor = "stiffness_error@body_1.ry:relative=-0.5", "motor_inertia_error@motor_2:relative=0.6"
    hidden = (spring, rotor, "backlash@motor_2:gap=0.006", "coulomb_friction@motor_1:level=15", *load)
    record = measured(elastic_arm(), *hidden, gain=(3e3, 100.0), shaken=20.0, seconds=seconds)
    sizes = sizes_of(record, elastic_arm(), BEHIND_SPRINGS)
    assert sizes.keys() == {one.partition(":")[0] for one in hidden}
    assert sizes["backlash@motor_2"]["gap"] == pytest.approx(0.006, rel=0.01)
    assert sizes["stiffness_error@body_1.ry"]["relative"] == pytest.approx(-0.5, abs=0.01)


@cache
def rigid_arm() -> Robot:
    """The same arm without springs, whose file states its rotors."""
    joints = [
        {"ry": {"spring": "rigid", "motor": {"inertia": inertia, "viscous_friction": 8.0}}} for inertia in (4.0, 1.5)
    ]
    return robot_of("rigid_arm", *joints, length=0.4)


@pytest.mark.parametrize(("load", "size"), [
    ("tool_load@tool:mass=0.4,x=0.5,z=0.3", {"mass": 0.4, "x": 0.5, "z": 0.3}),
    ("payload_error@tool:relative=0.1", {"relative": 0.1}),
])  # fmt: skip
def test_a_light_load_is_found_where_torques_leave_a_doubt(load: str, size: dict[str, float]) -> None:
    """Without it, offsets, inertias and a payload stand for it, which as a point load would be of the same torques."""
    record = measured(rigid_arm(), load, *FRICTION, gain=(2e4, 800.0))
    sizes = sizes_of(record, rigid_arm())
    assert sizes.keys() == {one.partition(":")[0] for one in (load, *FRICTION)}
    assert sizes[load.partition(":")[0]] == pytest.approx(size, rel=0.05)
