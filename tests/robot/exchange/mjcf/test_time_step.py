"""Integrator and time step of a new MJCF: stable for stiff servos, and accurate where nothing is stiff."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

WRIST = """name: wrist
gravity: [0, 0, -9.81]
sample_time: 0.002
bodies:
  - {{mass: 3, center_of_mass: [0.2, 0, 0], inertia: {{yy: 0.05}}, length: [0.4, 0, 0],
     directions: {{ry: {{spring: rigid, motor: {{inertia: 0.1, servo: {{stiffness: 2000, damping: 400}}}}}}}}}}
  - {{mass: 0.2, center_of_mass: [0.02, 0, 0], inertia: {{yy: 2.0e-4}},
     directions: {{ry: {{spring: rigid, motor: {{inertia: 0, servo: {servo}}}}}}}}}
outputs: {{joints: {{coordinates: [body_1.ry, body_2.ry]}}}}
controlled: joints
"""


def options(folder: Path, stiffness: float, damping: float) -> tuple[str, float, str]:
    """Text of the exported file, its time step [s] and integrator."""
    file = folder / "wrist.yaml"
    file.write_text(WRIST.format(servo=f"{{stiffness: {stiffness}, damping: {damping}}}"))
    text = export_model(load_patched(file), "mjcf").text
    option = mujoco.MjModel.from_xml_string(text).opt
    return text, option.timestep, mujoco.mjtIntegrator(option.integrator).name


def motion(text: str, step: float) -> np.ndarray:
    """Positions at 50 Hz while the servos follow a motion [rad]."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    data, rows = mujoco.MjData(model), []
    for k in range(50):
        data.ctrl[:] = 0.4 * np.sin(0.08 * k), 0.5 * np.sin(0.13 * k)
        for _ in range(round(0.02 / step)):
            mujoco.mj_step(model, data)
        rows.append(data.qpos.copy())
    return np.array(rows)


def test_stiff_servos_at_light_bodies_are_stable_as_written(tmp_path: Path) -> None:
    text, step, integrator = options(tmp_path, 500, 100)
    assert (step, integrator) == (0.002, "mjINT_IMPLICITFAST")
    assert np.abs(motion(text, step) - motion(text, step / 40)).max() < 2e-3
    explicit = motion(text.replace("implicitfast", "RK4"), step)
    assert not np.abs(explicit - motion(text, step / 40)).max() < 0.1


def test_a_step_resolves_the_fastest_vibration(tmp_path: Path) -> None:
    text, step, integrator = options(tmp_path, 2000, 0.05)
    assert (step, integrator) == (0.002 / 32, "mjINT_IMPLICITFAST")
    assert np.abs(motion(text, step) - motion(text, step / 8)).max() < 5e-3


@pytest.mark.parametrize("name", ["two_mass", "elbow", "six_axis", "flexible_arm"])
def test_without_stiff_parts_the_sample_time_and_rk4_stay(name: str) -> None:
    patched = load_patched(name)
    option = mujoco.MjModel.from_xml_string(export_model(patched, "mjcf").text).opt
    assert option.timestep == patched.base.sample_time
    assert option.integrator == mujoco.mjtIntegrator.mjINT_RK4


def test_friction_of_a_patch_counts(tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: two_mass\neffects:\n  - {effect: viscous_friction, location: motor_1, parameters: {coefficient: 1e5}}\n"
    )
    text = export_model(load_patched(patch), "mjcf").text
    assert 'integrator="implicitfast"' in text
