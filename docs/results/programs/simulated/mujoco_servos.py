"""Write mujoco_servos.md: python docs/results/programs/simulated/mujoco_servos.py [FOLDER [SEED ...]].

A diagnosis takes some minutes; the seeds of the page are SEEDS.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_model, load_patched
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.report.files import write_diagnosis
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import JointSeries, Log
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.schema import Diagnosis

SEEDS = (41, 42, 43, 44, 51, 52, 53, 54, 61, 62, 63, 64)
DURATION = 12.0
"""Duration of each log [s]."""
HEAD = """# Position actuators of MuJoCo

Written by `python docs/results/programs/simulated/mujoco_servos.py`.
An arm of three joints with `<position>` actuators is simulated by
MuJoCo; five of its numbers (gain `kp`, `armature`, `damping`, `frictionloss`, at joints drawn with the seed) differ
from the nominal MJCF. The logs hold commanded and measured positions at {rate} Hz, {duration:g} s, with noise of
{noise:g} rad, and **no torques**. The nominal MJCF is imported by `flexros import-mjcf`, which takes `kp` and `kv` as
the servo of each motor; tolerances are 1 %. The first log is fitted, the second is held out. The patch is exported into
the nominal MJCF, and MuJoCo runs a third command with the nominal, the repaired and the true model: the last two
columns are the rms differences from the true positions. Seeds 11 to 34 were used before, those of
this page were not. Run by commit 5d26139b.

| seed | differs | verdict | named | gap before | after | closed, held out | nominal run | repaired run |
|---|---|---|---|---|---|---|---|---|
"""

ARM = """<mujoco model="servo_arm">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.0001" gravity="0 0 -9.81" integrator="implicitfast"/>
  <worldbody>
    <body name="turret" pos="0 0 0.2">
      <joint name="yaw" axis="0 0 1" {yaw}/>
      <inertial pos="0 0 0.05" mass="2" diaginertia="0.01 0.01 0.008"/>
      <body name="upper" pos="0 0 0.1">
        <joint name="shoulder" axis="0 1 0" {shoulder}/>
        <inertial pos="0 0 0.15" mass="1.5" diaginertia="0.015 0.015 0.003"/>
        <body name="fore" pos="0 0 0.3">
          <joint name="elbow" axis="0 1 0" {elbow}/>
          <inertial pos="0 0 0.12" mass="0.8" diaginertia="0.006 0.006 0.001"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="yaw" joint="yaw" {yaw_servo}/>
    <position name="shoulder" joint="shoulder" {shoulder_servo}/>
    <position name="elbow" joint="elbow" {elbow_servo}/>
  </actuator>
</mujoco>
"""
JOINTS = ("yaw", "shoulder", "elbow")
NOMINAL: dict[str, tuple[float, ...]] = {
    "kp": (60.0, 90.0, 40.0),
    "kv": (2.0, 3.0, 1.0),
    "armature": (0.05, 0.06, 0.02),
    "damping": (0.3, 0.4, 0.15),
    "frictionloss": (0.0, 0.0, 0.0),
}
NOISE = 1e-4
"""Noise of the encoders, rms [rad]."""
RATE = 250
"""Samples and commands per second."""


@dataclass(frozen=True)
class ServoArm:
    """An arm.

    Attributes:
        numbers: kp [Nm/rad], kv [Nm s/rad], armature [kg m2], damping [Nm s/rad] and frictionloss [Nm], one per joint.
    """

    numbers: dict[str, tuple[float, ...]]

    @property
    def text(self) -> str:
        """The MJCF."""
        words = {}
        for k, joint in enumerate(JOINTS):
            own = {name: values[k] for name, values in self.numbers.items()}
            words[joint] = (
                f'armature="{own["armature"]}" damping="{own["damping"]}" frictionloss="{own["frictionloss"]}" '
                'solreffriction="0.0005 1"'
            )
            words[f"{joint}_servo"] = f'kp="{own["kp"]}" kv="{own["kv"]}" forcerange="-40 40"'
        return ARM.format(**words)


def drawn(seed: int) -> tuple[ServoArm, dict[tuple[str, str], float]]:
    """Draw an arm that differs from the nominal one; also returns (effect, motor) with its size.

    Args:
        seed: Seed of the draw.
    """
    random = np.random.default_rng(seed)
    numbers = {name: list(values) for name, values in NOMINAL.items()}
    causes: dict[tuple[str, str], float] = {}
    kinds = ("kp", "armature", "damping", "frictionloss")
    places = [(kind, joint) for kind in kinds for joint in range(len(JOINTS))]
    for index in random.choice(len(places), 5, replace=False).tolist():
        kind, joint = places[index]
        motor = f"motor_{joint + 1}"
        if kind == "frictionloss":
            numbers[kind][joint] = size = float(random.uniform(0.2, 0.6)) * (0.5 if joint == 2 else 1.0)
            causes["coulomb_friction", motor] = size
        elif kind == "damping":
            size = float(random.uniform(0.25, 0.6)) * NOMINAL["kv"][joint]
            numbers[kind][joint] += size
            causes["viscous_friction", motor] = size
        else:
            size = float(random.uniform(0.15, 0.4)) * float(random.choice([-1, 1]))
            numbers[kind][joint] *= 1 + size
            effect = "servo_stiffness_error" if kind == "kp" else "motor_inertia_error"
            causes[effect, motor] = size
    return ServoArm({name: tuple(values) for name, values in numbers.items()}), causes


def command(seed: int, duration: float) -> FloatArray:
    """Return commanded positions [rad], shape (n, 3): sums of sines between pauses, and steps.

    Args:
        seed: Seed of phases and steps.
        duration: Duration [s].
    """
    random = np.random.default_rng([seed, 1])
    time = np.arange(round(duration * RATE)) / RATE
    columns = []
    for amplitude in (0.5, 0.4, 0.6):
        frequencies = np.array([0.15, 0.4, 0.9, 2.0, 4.0]) * random.uniform(0.85, 1.15, 5)
        weights = amplitude / np.array([1.0, 2.0, 5.0, 14.0, 40.0])
        phases = random.uniform(0, 2 * np.pi, 5)
        column = np.sin(2 * np.pi * frequencies * time[:, None] + phases) @ weights
        jumps = np.repeat(random.uniform(-0.1, 0.1, round(duration) // 2 + 1), 2 * RATE)[: len(time)]
        columns.append(np.minimum(time / 1.0, 1.0) * (column + jumps))
    return np.column_stack(columns)


def run(model: Any, wanted: FloatArray, seed: int | None = None) -> FloatArray:
    """Return the positions at the samples of held commands [rad], shape (n, 3).

    Args:
        model: The model, mujoco.MjModel.
        wanted: Commanded positions [rad], shape (n, 3).
        seed: Seed of the noise; None without noise.
    """
    data = mujoco.MjData(model)
    data.ctrl[:] = wanted[0]
    for _ in range(100_000):  # it begins at rest
        mujoco.mj_step(model, data)
    substeps = round(1 / RATE / model.opt.timestep)
    positions = np.empty_like(wanted)
    for k, row in enumerate(wanted):
        positions[k] = data.qpos
        data.ctrl[:] = row
        for _ in range(substeps):
            mujoco.mj_step(model, data)
    if seed is not None:
        positions += NOISE * np.random.default_rng([seed, 2]).normal(size=positions.shape)
    return positions


def log_of(wanted: FloatArray, positions: FloatArray) -> Log:
    """Return a log of commanded and measured positions, without torques."""
    stamp = START_NS + np.arange(len(wanted)) * (10**9 // RATE)
    names = tuple(f"motor_{k + 1}" for k in range(len(JOINTS)))
    return Log(
        joint_states=JointSeries(stamp, names, position=positions),
        joint_commands=JointSeries(stamp, names, position=wanted),
        provenance={"import": {"mapping": {"name": "MuJoCo"}}},
    )


def robot_text(imported: str) -> str:
    """Return an imported robot file with the rate and the noise of the logs, and tolerances of 1 %."""
    text = imported.replace("sample_time: 0.0001", f"sample_time: {1 / RATE}").replace(
        "tolerance: 0.03", "tolerance: 0.01"
    )
    return text.replace("bodies:", f"sensors: {{encoder_noise: {NOISE}}}\nbodies:", 1)


def diagnosed(seed: int, folder: Path) -> tuple[Diagnosis, FloatArray]:
    """Diagnose the logs of a drawn arm.

    Args:
        seed: Seed of the arm and its logs.
        folder: Empty folder for the files.

    Returns:
        The diagnosis, and the rms differences from the true positions of the nominal and the repaired run [rad].
    """
    base, file, arm = folder / "nominal.xml", folder / "robot.yaml", drawn(seed)[0]
    base.write_text(ServoArm(NOMINAL).text, encoding="utf-8")
    file.write_text(robot_text(robot_from_mjcf(base).text), encoding="utf-8")
    known, truth = load_model(file), mujoco.MjModel.from_xml_string(arm.text)
    records = []
    for own in (seed, seed + 1000):
        wanted = command(own, DURATION)
        records.append(checked_log(log_of(wanted, run(truth, wanted, own)), known.robot, name=f"log {own}"))
    result = diagnose(records[0], known, holdout=records[1])
    write_diagnosis(result, str(file), folder / "diagnosis")
    wanted = command(seed + 2000, DURATION)
    patch = folder / "diagnosis" / "patch.yaml"
    repaired = base if not patch.is_file() else folder / "repaired.xml"
    if patch.is_file():
        repaired.write_text(export_model(load_patched(patch), "mjcf", base).text, encoding="utf-8")
    true = run(truth, wanted)
    runs = [run(mujoco.MjModel.from_xml_path(str(path)), wanted) for path in (base, repaired)]
    return result.diagnosis, np.array([np.sqrt(np.mean((each - true) ** 2)) for each in runs])


def row(seed: int, diagnosis: Diagnosis, differences: FloatArray) -> str:
    """Return the row of a seed; sizes of named effects with their standard deviations."""
    differs = "; ".join(f"{name} {motor} {size:.3g}" for (name, motor), size in sorted(drawn(seed)[1].items()))
    named = [
        f"{cause.effect} {cause.location} "
        + ", ".join(f"{one.value:.3g} ± {one.std:.2g}" for one in cause.parameters.values() if one.std is not None)
        for cause in diagnosis.causes
        if cause.probability > 0.5
    ]
    gap, (nominal, repaired) = diagnosis.gap, 1e3 * differences
    closed = "-" if gap.closed_fraction is None else f"{100 * gap.closed_fraction:.1f} %"
    after = "-" if gap.after is None else f"{gap.after:.3g}"
    return (
        f"| {seed} | {differs} | {diagnosis.verdict} | {'; '.join(named)} | {gap.before:.3g} | {after} | {closed} | "
        f"{nominal:.2f} mrad | {repaired:.2f} mrad |\n"
    )


def main() -> None:
    """Diagnose robots that are drawn at random, and write the page."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[2], help="folder of the page")
    parser.add_argument("seeds", nargs="*", type=int, default=SEEDS, help="seeds of the robots")
    given = parser.parse_args()
    folder = given.folder
    folder.mkdir(parents=True, exist_ok=True)
    written = HEAD.format(rate=RATE, duration=DURATION, noise=NOISE)
    for drawn_seed in given.seeds:
        with tempfile.TemporaryDirectory() as made:
            written += row(drawn_seed, *diagnosed(drawn_seed, Path(made)))
        (folder / "mujoco_servos.md").write_text(written, encoding="utf-8")


if __name__ == "__main__":
    main()
