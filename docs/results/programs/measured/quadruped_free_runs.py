"""Least squares of free runs of legs: python docs/results/programs/measured/quadruped_free_runs.py FETCHED.

It gives what real_robots.md calls known of the Go2. MuJoCo runs each leg with its commanded positions from the first
measured position through the whole log, without our diagnosis. Armature, damping and dry friction of the three joints
and one delay are fitted to the measured positions; gains, masses and the body are those of the repository. FETCHED is
the folder of fetch_real_robots.py.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from quadruped_legs import LEGS, RATE, REPOSITORY
from scipy.optimize import least_squares

SUBSTEPS = 5
FIRST = np.array([0.01, 0.01, 0.01, 0.6, 0.6, 0.6, 0.2, 0.2, 0.2, 0.002])
"""Armature [kg m2], damping [Nm s/rad] and dry friction [Nm] of the joints by the MJCF, and a delay [s]."""
HIGHEST = np.array([0.3] * 3 + [3.0] * 3 + [5.0] * 3 + [0.03])


def simulated(model: mujoco.MjModel, command: np.ndarray, first: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Run a leg, shape (n, 3) [rad]; a delay between two steps is a mean of their commands."""
    model.dof_armature[:], model.dof_damping[:], model.dof_frictionloss[:] = numbers[:9].reshape(3, 3)
    data = mujoco.MjData(model)
    data.qpos[:] = first
    out = np.empty_like(command)
    held = np.repeat(command, SUBSTEPS, axis=0)
    steps = numbers[9] * RATE * SUBSTEPS
    whole, part = int(steps), steps - int(steps)
    later = [np.concatenate([np.repeat(held[:1], k, axis=0), held])[: len(held)] for k in (whole, whole + 1)]
    acting = (1 - part) * later[0] + part * later[1]
    for n in range(len(command)):
        out[n] = data.qpos
        for step in range(SUBSTEPS):
            data.ctrl[:] = acting[n * SUBSTEPS + step]
            mujoco.mj_step(model, data)
    return out


def main() -> None:
    """Fit the legs and print their numbers."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("fetched", type=Path, help="folder of fetch_real_robots.py")
    folder: Path = parser.parse_args().fetched
    for leg in LEGS:
        table = np.loadtxt(folder / REPOSITORY / f"{leg}.csv", delimiter=",", skiprows=1)
        position, command = table[:, 1:4], table[:, 4:7]
        model = mujoco.MjModel.from_xml_path(str(folder / REPOSITORY / f"{leg}.xml"))
        model.opt.timestep, model.opt.integrator = 1 / RATE / SUBSTEPS, mujoco.mjtIntegrator.mjINT_IMPLICITFAST

        def errors(numbers: np.ndarray, run: tuple[Any, ...] = (model, command, position)) -> np.ndarray:
            return np.asarray((simulated(run[0], run[1], run[2][0], numbers) - run[2])[RATE:].ravel())

        bounds = (np.full(10, 1e-4), HIGHEST)
        found = least_squares(errors, FIRST, bounds=bounds, x_scale=FIRST, diff_step=1e-2, max_nfev=15)
        armature, damping, friction = (np.round(row, 4).tolist() for row in found.x[:9].reshape(3, 3))
        before, after = (1e3 * np.sqrt(np.mean(one**2)) for one in (errors(FIRST), found.fun))
        print(
            f"{leg}: armature {armature}, damping {damping}, dry friction {friction}, delay {1e3 * found.x[9]:.1f} ms"
        )
        print(f"    {before:.1f} mrad rms before, {after:.1f} after", flush=True)


if __name__ == "__main__":
    main()
