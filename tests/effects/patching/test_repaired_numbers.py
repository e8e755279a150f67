"""Effects as numbers of joints and bodies."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.effects.patching.patched_robot import load_patched
from flexros.effects.patching.repaired_numbers import repaired_numbers
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.exchange.numbers import RepairedNumbers


def numbers(tmp_path: Path, *effects: str, robot: str = "elbow") -> RepairedNumbers:
    file = tmp_path / "patch.yaml"
    file.write_text("\n".join([f"robot: {robot}", "effects:", *(f"  - {{{effect}}}" for effect in effects)]))
    return repaired_numbers(load_patched(file))


def test_effects_add_up(tmp_path: Path) -> None:
    first = numbers(
        tmp_path,
        "effect: coulomb_friction, location: motor_1, parameters: {level: 3}",
        "effect: presliding_friction, location: motor_1, parameters: {level: 2, stiffness: 1e5}",
        "effect: viscous_friction, location: motor_1, parameters: {coefficient: 5}",
        "effect: torque_saturation, location: motor_1, parameters: {limit: 500}",
        "effect: delay, location: all, parameters: {time: 0.001}",
        "effect: delay, location: motor_1, parameters: {time: 0.002}",
        "effect: stiffness_error, location: body_1.ry, parameters: {relative: 0.5}",
    ).joints[0]
    assert (first.friction, first.damping, first.torque_limit) == (5, 65, 500)
    assert first.delay == pytest.approx(0.003)
    assert first.stiffness == 3e5


def test_zero_and_listed_effects_count_as_a_joint_that_is_turned_round(tmp_path: Path) -> None:
    file = tmp_path / "patch.yaml"
    offset = "{effect: encoder_offset, location: motor_1, parameters: {offset: 0.05}}"
    bias = "{effect: torque_bias, location: motor_2, parameters: {level: 0.26}}"
    file.write_text(f"robot: elbow\neffects: [{offset}, {bias}]\n")
    own, turned = (repaired_numbers(load_patched(file), turned=motors) for motors in ((), ("motor_1", "motor_2")))
    assert [joint.zero for joint in own.joints] == [0.05, 0.0]
    assert [joint.zero for joint in turned.joints] == [-0.05, 0.0]
    assert [each.size for each in (*own.not_held, *turned.not_held)] == ["level 0.26 Nm", "level -0.26 Nm"]


def test_what_is_held_in_part_is_listed(tmp_path: Path) -> None:
    held = numbers(
        tmp_path,
        "effect: presliding_friction, location: motor_1, parameters: {level: 2, stiffness: 1e5}",
        "effect: gravity_error, location: body_2, parameters: {relative: 0.1}",
        "effect: hysteresis, location: motor_2, parameters: {level: 4}",
        "effect: extra_mode, location: tool, parameters: {frequency: 20, ratio: 0.1}",
        "effect: torque_ripple, location: motor_1, parameters: {amplitude: 0}",
    )
    assert [(row.location, row.name) for row in held.not_held] == [
        ("motor_1", "presliding_friction"),
        ("motor_2", "hysteresis"),
        ("tool", "extra_mode"),
    ]
    assert held.bodies[1].weight_error == 0.1


def test_payload_is_a_factor(tmp_path: Path) -> None:
    bodies = numbers(tmp_path, "effect: payload_error, location: tool, parameters: {relative: 0.2}").bodies
    assert [body.mass_factor for body in bodies] == [1, pytest.approx(1.2)]


def test_an_inertia_is_a_factor_beyond_that_of_the_mass(tmp_path: Path) -> None:
    payload = "effect: payload_error, location: tool, parameters: {relative: 0.2}"
    inertia = "effect: inertia_error, location: body_2, parameters: {relative: -0.6}"
    body = numbers(tmp_path, payload, inertia).bodies[1]
    assert (body.mass_factor, body.inertia_factor) == pytest.approx((1.2, 0.4))
    assert body.change == ("inertia", "x 0.48, mass x 1.2")
    difference = "effect: body_difference, location: body_2, parameters: {x: 0.01}"
    assert numbers(tmp_path, difference, inertia).bodies[1].change[0] == "numbers"


def test_a_centre_of_mass_elsewhere_is_said_with_the_mass(tmp_path: Path) -> None:
    moved = "effect: center_error, location: body_2, parameters: {z: 0.02}"
    name, size = numbers(tmp_path, moved).bodies[1].change
    center = load_robot("elbow").spec.bodies[1].center_of_mass.value
    assert name == "numbers"
    assert size == f"mass 45 kg, centre {center[0]:.4g}, {center[1]:.4g}, {center[2] + 0.02:.4g} m, inertia yy 3 kg m2"


def test_motor_side_with_several_gears_is_refused(tmp_path: Path) -> None:
    data = load_robot("elbow").spec.model_dump_json()
    file = tmp_path / "motor.yaml"
    file.write_text(data.replace('"coordinates":"arm"', '"coordinates":"motor"'))
    with pytest.raises(InputError, match="coordinates: motor"):
        repaired_numbers(load_patched(file))
