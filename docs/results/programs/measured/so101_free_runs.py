"""Least squares of free runs of the SO-101: python docs/results/programs/measured/so101_free_runs.py FETCHED [LOG]...

It gives what real_robots.md calls known of that arm. Its MJCF runs in MuJoCo with the commanded positions, from the
first measured position through 60 s of each log, without our diagnosis. Stiffness of the servo, dry friction, damping
and armature of five joints, an offset of each command and one delay are fitted to the measured positions; the masses
are those of the MJCF. FETCHED is the folder of fetch_real_robots.py, LOG a motion of the arm.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np
from scipy.optimize import least_squares

RATE, SUBSTEPS, JOINTS, LENGTH = 49.85, 10, 5, 3000
MODEL = "SO-ARM100/Simulation/SO101/so101_new_calib.xml"
LOGS = "sage/output/real/so101/custom"
FIRST = np.concatenate([np.log(np.repeat([15.0, 0.2, 0.5, 0.02], JOINTS)), np.zeros(JOINTS), [0.02]])
"""Logarithms of stiffness, dry friction, damping and armature, then offsets and a delay [Nm, rad, s, kg m2]."""
LOWEST = np.concatenate([np.log(np.repeat([1.0, 1e-3, 1e-3, 1e-4], JOINTS)), np.full(JOINTS, -0.1), [0.0]])
HIGHEST = np.concatenate([np.log(np.repeat([500.0, 5.0, 20.0, 1.0], JOINTS)), np.full(JOINTS, 0.1), [0.2]])
SCALE = np.concatenate([np.full(4 * JOINTS, 0.3), np.full(JOINTS, 0.02), [0.01]])


def column(path: Path) -> np.ndarray:
    """Read the positions of all joints [rad], shape (n, 6)."""
    rows = [row.split('"')[1] for row in path.read_text().splitlines()[1:]]
    return np.array([json.loads(row) for row in rows])


def without_meshes(path: Path) -> mujoco.MjModel:
    """Load the arm; all bodies have their masses in the file, so that no shape counts."""
    specification = mujoco.MjSpec.from_string(
        "\n".join(line for line in path.read_text().splitlines() if "<geom" not in line and "<mesh" not in line)
    )
    model = specification.compile()
    model.opt.timestep, model.opt.integrator = 1 / RATE / SUBSTEPS, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.jnt_limited[:] = model.actuator_ctrllimited[:] = model.actuator_forcelimited[:] = 0
    model.actuator_biasprm[:, 2] = 0.0  # what brakes is the damping of the joints
    return model


def simulated(model: mujoco.MjModel, command: np.ndarray, first: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Run the arm, shape (n, 5) [rad]; a delay between two steps is a mean of their commands."""
    stiffness, friction, damping, armature = np.exp(numbers[: 4 * JOINTS].reshape(4, JOINTS))
    model.dof_frictionloss[:JOINTS], model.dof_damping[:JOINTS], model.dof_armature[:JOINTS] = (
        friction,
        damping,
        armature,
    )
    model.actuator_gainprm[:JOINTS, 0], model.actuator_biasprm[:JOINTS, 1] = stiffness, -stiffness
    data = mujoco.MjData(model)
    data.qpos[:JOINTS] = first
    held = np.repeat(command + numbers[4 * JOINTS : 5 * JOINTS], SUBSTEPS, axis=0)
    steps = numbers[-1] * RATE * SUBSTEPS
    whole, part = int(steps), steps - int(steps)
    later = [np.concatenate([np.repeat(held[:1], k, axis=0), held])[: len(held)] for k in (whole, whole + 1)]
    acting = (1 - part) * later[0] + part * later[1]
    out = np.empty_like(command)
    for n in range(len(command)):
        out[n] = data.qpos[:JOINTS]
        for step in range(SUBSTEPS):
            data.ctrl[:JOINTS] = acting[n * SUBSTEPS + step]
            mujoco.mj_step(model, data)
    return out


def main() -> None:
    """Fit the logs and print their numbers."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("fetched", type=Path, help="folder of fetch_real_robots.py")
    parser.add_argument("logs", nargs="*", default=["multisine", "friction_gravity", "chirp_sweep"], help="motions")
    given = parser.parse_args()
    folder: Path = given.fetched
    model = without_meshes(folder / MODEL)
    for log in given.logs:
        position, command = (
            column(folder / LOGS / log / f"{name}.csv")[:LENGTH, :JOINTS] for name in ("state_motor", "control")
        )

        def errors(numbers: np.ndarray, command: np.ndarray = command, position: np.ndarray = position) -> np.ndarray:
            return np.asarray((simulated(model, command, position[0], numbers) - position).ravel())

        found = least_squares(errors, FIRST, bounds=(LOWEST, HIGHEST), x_scale=SCALE, diff_step=1e-3, max_nfev=15)
        rows = np.exp(found.x[: 4 * JOINTS].reshape(4, JOINTS))
        print(f"{log}: {1e3 * np.sqrt(np.mean(found.fun**2)):.2f} mrad rms, delay {1e3 * found.x[-1]:.1f} ms")
        for name, row in zip(("stiffness", "dry friction", "damping", "armature"), rows, strict=True):
            print(f"    {name}: {np.round(row, 4).tolist()}", flush=True)


if __name__ == "__main__":
    main()
