"""Write mujoco_six_axis_servos.md.

python docs/results/programs/simulated/mujoco_six_axis_servos.py [FOLDER [SEED ...]]

A diagnosis takes some minutes; the seeds of the page are SEEDS.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from flexros.effects.patching.patched_robot import load_model
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import JointSeries, Log
from flexros.provenance import code_version
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.schema import Diagnosis

SEEDS = (77, 78, 79, 80, 81, 82)
RATE, DURATION = 125, 20.0
"""Samples and commands per second, and duration of each log [s]."""
NOISE = 1e-4
"""Noise of the encoders, rms [rad]."""
AMPLITUDE = 0.12
"""Unit of the amplitudes of the sines of the commands: the slowest one has three [rad]."""
POSE = (0.0, -1.2, 1.4, -0.8, 0.5, 0.2)
"""Commanded positions at the beginning [rad]."""
ARM = Path(__file__).parents[3] / "examples" / "ur5e.urdf"
NOMINAL: dict[str, tuple[float, ...]] = {
    "kp": (900.0, 1200.0, 700.0, 150.0, 120.0, 80.0),
    "kv": (60.0, 80.0, 45.0, 9.0, 7.0, 5.0),
    "armature": (1.4, 1.4, 1.1, 0.25, 0.25, 0.2),
    "damping": (4.0, 4.0, 3.0, 0.6, 0.6, 0.4),
    "frictionloss": (0.0,) * 6,
}
"""Gains [Nm/rad, Nm s/rad], rotors [kg m2], viscous [Nm s/rad] and dry friction [Nm] of the six joints."""
HEAD = """# Six position servos of MuJoCo

Written by `python docs/results/programs/simulated/mujoco_six_axis_servos.py`.
A UR5e with `<position>` actuators is simulated by MuJoCo. Two gains, two rotors, two viscous and three dry frictions,
at joints drawn with the seed, differ from the nominal MJCF; most arms carry a load that it lacks, and most servos get
their commands some samples late. The logs hold commanded and measured positions at {rate} Hz, {duration:g} s, with
noise of {noise:g} rad, and **no torques**. The first log is fitted, the second is held out. Seeds 1 to 3 and 41 to 76
were used before, those of this page were not. Written by code {code}.
*Found* is what was named alone; *ambiguous* is what was named as one of several that the log does not tell apart, as at
a wrist without weight, where the numbers of a servo have a common factor. *False* is what was named without being true,
alone or in a group of which nothing is true. *Sizes* are those of what was found within their 95 % intervals.

| seed | found | ambiguous | missed | false | verdict | gap before | after | closed, held out | sizes |
|---|---|---|---|---|---|---|---|---|---|
"""

Truth = dict[tuple[str, str], float]


def arm(numbers: dict[str, tuple[float, ...]], load: float = 0.0) -> Any:
    """Return the arm, mujoco.MjSpec.

    Args:
        numbers: Numbers of the joints, as in NOMINAL.
        load: Mass of the load behind the last flange [kg].
    """
    spec = mujoco.MjSpec.from_file(str(ARM))
    spec.option.timestep = 0.0005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    for k, joint in enumerate(spec.joints):
        own = {name: values[k] for name, values in numbers.items()}
        joint.armature, joint.frictionloss = own["armature"], own["frictionloss"]
        joint.damping = [own["damping"], 0, 0] if np.ndim(joint.damping) else own["damping"]  # MuJoCo 4: a polynomial
        joint.solref_friction = [0.0005, 1.0]
        servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=own["kp"], kv=own["kv"])
    if load:
        side = 0.06
        inertia = load * side**2 / 6
        body = spec.body("wrist_3_link").add_body(name="load", pos=[0, 0, 0.08])
        body.mass, body.inertia, body.explicitinertial = load, [inertia] * 3, True
    return spec


def drawn(seed: int) -> tuple[dict[str, tuple[float, ...]], float, int, Truth]:
    """Draw an arm: numbers of its joints, load [kg], delay of the commands [samples], and effects with their sizes.

    Args:
        seed: Seed of the draw.
    """
    random = np.random.default_rng(seed)
    numbers, truth = {name: list(values) for name, values in NOMINAL.items()}, Truth()
    for kind, effect in (("kp", "servo_stiffness_error"), ("armature", "motor_inertia_error")):
        for joint in random.choice(6, 2, replace=False).tolist():
            size = float(random.uniform(0.15, 0.4)) * float(random.choice([-1, 1]))
            numbers[kind][joint] *= 1 + size
            truth[effect, f"motor_{joint + 1}"] = size
    for joint in random.choice(6, 3, replace=False).tolist():
        numbers["frictionloss"][joint] = size = float(random.uniform(0.006, 0.02)) * NOMINAL["kp"][joint]
        truth["coulomb_friction", f"motor_{joint + 1}"] = size
    for joint in random.choice(6, 2, replace=False).tolist():
        size = float(random.uniform(0.25, 0.6)) * NOMINAL["kv"][joint]
        numbers["damping"][joint] += size
        truth["viscous_friction", f"motor_{joint + 1}"] = size
    load = float(random.uniform(0.4, 1.5)) if random.random() < 0.7 else 0.0
    delay = int(random.integers(1, 4)) if random.random() < 0.6 else 0
    if load:
        truth["tool_load", "tool"] = load
    if delay:
        truth["delay", "all"] = delay / RATE
    return {name: tuple(values) for name, values in numbers.items()}, load, delay, truth


def command(seed: int) -> FloatArray:
    """Return commanded positions of the joints [rad], shape (n, 6): sums of sines, and steps.

    Args:
        seed: Seed of phases and steps.
    """
    random = np.random.default_rng([seed, 1])
    time = np.arange(round(DURATION * RATE)) / RATE
    columns = []
    for pose in POSE:
        frequencies = np.array([0.15, 0.4, 0.9, 2.0, 4.0]) * random.uniform(0.85, 1.15, 5)
        weights = AMPLITUDE * np.array([3.0, 1.5, 0.6, 0.2, 0.08])
        column = np.sin(2 * np.pi * frequencies * time[:, None] + random.uniform(0, 2 * np.pi, 5)) @ weights
        jumps = np.repeat(random.uniform(-0.05, 0.05, round(DURATION) // 2 + 1), 2 * RATE)[: len(time)]
        columns.append(pose + np.minimum(time, 1.0) * (column + jumps))
    return np.column_stack(columns)


def log_of(spec: Any, delay: int, seed: int, signs: Sequence[int]) -> Log:
    """Run an arm, and return a log of commanded and measured positions, without torques.

    Args:
        spec: The arm, mujoco.MjSpec.
        delay: Samples by which its servos get their commands late.
        seed: Seed of commands and noise.
        signs: Senses of the motors of the imported robot against those of the joints.
    """
    model = spec.compile()
    data, wanted = mujoco.MjData(model), command(seed)
    data.qpos[:] = data.ctrl[:] = wanted[0]
    for _ in range(20_000):  # it begins at rest
        mujoco.mj_step(model, data)
    positions = np.empty_like(wanted)
    for k in range(len(wanted)):
        positions[k] = data.qpos
        data.ctrl[:] = wanted[max(k - delay, 0)]
        for _ in range(round(1 / RATE / model.opt.timestep)):
            mujoco.mj_step(model, data)
    positions += NOISE * np.random.default_rng([seed, 2]).normal(size=positions.shape)
    stamp, names = START_NS + np.arange(len(wanted)) * (10**9 // RATE), tuple(f"motor_{k + 1}" for k in range(6))
    return Log(
        joint_states=JointSeries(stamp, names, position=np.multiply(signs, positions)),
        joint_commands=JointSeries(stamp, names, position=np.multiply(signs, wanted)),
        provenance={"import": {"mapping": {"name": "MuJoCo"}}},
    )


def nominal_model(folder: Path) -> tuple[RobotWithEffects, list[int]]:
    """Import the nominal arm; also returns the senses of its motors against those of the joints.

    Args:
        folder: Empty folder for the files.
    """
    base, file = folder / "nominal.xml", folder / "robot.yaml"
    nominal = arm(NOMINAL)
    nominal.compile()
    base.write_text(nominal.to_xml(), encoding="utf-8")
    imported = robot_from_mjcf(base)
    text = imported.text.replace("sample_time: 0.0005", f"sample_time: {1 / RATE}")
    file.write_text(text.replace("bodies:", f"sensors: {{encoder_noise: {NOISE}}}\nbodies:", 1), encoding="utf-8")
    return load_model(file), [one.sign for one in imported.joints]


def diagnosed(seed: int, folder: Path) -> Diagnosis:
    """Diagnose the logs of a drawn arm.

    Args:
        seed: Seed of the arm and its logs.
        folder: Empty folder for the files.
    """
    known, signs = nominal_model(folder)
    numbers, load, delay, _ = drawn(seed)
    records = [
        checked_log(log_of(arm(numbers, load), delay, own, signs), known.robot, name=f"log {own}")
        for own in (seed, seed + 1000)
    ]
    return diagnose(records[0], known, holdout=records[1]).diagnosis


def row(seed: int, diagnosis: Diagnosis) -> str:
    """Return the row of a seed."""
    truth = drawn(seed)[3]
    groups = [{(one.effect, one.location) for one in group} for group in diagnosis.ambiguity_groups]
    grouped = set().union(*groups)
    named = {(one.effect, one.location): one for one in diagnosis.causes if one.probability > 0.5}
    alone = named.keys() - grouped
    found, ambiguous = truth.keys() & alone, truth.keys() & grouped
    false = (alone - truth.keys()) | set().union(*(group for group in groups if not group & truth.keys()))
    sizes = [
        abs(size.value - truth[place]) <= 1.96 * size.std
        for place in found
        if (size := next(iter(named[place].parameters.values()))).std is not None
    ]
    gap = diagnosis.gap

    def words(places: set[tuple[str, str]]) -> str:
        return ", ".join(" ".join(place) for place in sorted(places)) or "-"

    after = "-" if gap.after is None else f"{gap.after:.3g}"
    closed = "-" if gap.closed_fraction is None else f"{100 * gap.closed_fraction:.2f} %"
    missed = truth.keys() - alone - grouped
    return (
        f"| {seed} | {len(found)} of {len(truth)} | {words(ambiguous)} | {words(missed)} | {words(false)} | "
        f"{diagnosis.verdict} | {gap.before:.3g} | {after} | {closed} | {sum(sizes)} of {len(sizes)} |\n"
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
    written = HEAD.format(rate=RATE, duration=DURATION, noise=NOISE, code=code_version())
    for drawn_seed in given.seeds:
        with tempfile.TemporaryDirectory() as made:
            written += row(drawn_seed, diagnosed(drawn_seed, Path(made)))
        (folder / "mujoco_six_axis_servos.md").write_text(written, encoding="utf-8")


if __name__ == "__main__":
    main()
