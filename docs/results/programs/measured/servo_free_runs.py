"""Least squares of free runs of the hobby servo: python docs/results/programs/measured/servo_free_runs.py FETCHED.

It gives what real_robots.md calls known of that robot. Each experiment begins at rest in the middle; a servo with an
arm is simulated through all of them, without our diagnosis, and its numbers are fitted to the measured positions. Four
models differ in where the loop brakes, within its torque limit or beyond it, and in whether the weight of the arm is
free. FETCHED is the folder of fetch_real_robots.py.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

KINDS = ("chirp", "prbs", "triangle", "ramp", "square", "step")
RATE, SUBSTEPS = 50.0, 10
MASS, RADIUS, INERTIA = 0.354, 0.1683, 0.000498  # of the arm, by the MJCF [kg, m, kg m2 at its centre of mass]
NAMES = ("stiffness", "damping", "lag", "delay", "limit", "viscous", "coulomb", "rotor", "offset", "weight")
LOWEST = np.array([1, 0, 1e-3, 0, 0.5, 0, 0, 0, -0.1, 0])
HIGHEST = np.array([300, 20, 0.3, 0.1, 10, 5, 2, 0.5, 0.1, 3])
STARTS = {
    "within the limit": np.array([25, 5, 0.1, 0.01, 2.7, 0.01, 0.1, 0.005, 0, 1]),
    "beyond the limit": np.array([40, 0, 0.01, 0.02, 3, 0.4, 0.3, 0.02, 0.02, 1]),
}


def experiments(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read commands and measured positions [rad], one row per experiment, NaN behind its end."""
    found = json.loads((folder / "servo-sysid/src/sysid/dataset/dataset.json").read_text())["data"]
    chosen = [one for one in found if one["type"] in KINDS]
    longest = max(len(one["actions"]) for one in chosen)
    command, position = np.zeros((len(chosen), longest)), np.full((len(chosen), longest), np.nan)
    for row, one in enumerate(chosen):
        n = len(one["actions"])
        command[row, :n], command[row, n:] = one["actions"], one["actions"][-1]
        position[row, :n] = one["sensor_data"]
    return math.pi * command, math.pi * position


def simulated(command: np.ndarray, numbers: np.ndarray, within: bool) -> np.ndarray:
    """Simulate all experiments from rest."""
    k, d, lag, delay, limit, viscous, coulomb, rotor, offset, weight = numbers
    h, ahead = 1 / (RATE * SUBSTEPS), 20
    inertia = INERTIA + MASS * RADIUS**2 + rotor
    padded = np.hstack([np.zeros((len(command), ahead)), command])
    q, w, held = np.zeros((3, len(command)))
    out: np.ndarray = np.empty(command.shape)
    for n in range(command.shape[1]):
        out[:, n] = q
        for step in range(SUBSTEPS):
            wanted = padded[:, max(math.floor(n + step / SUBSTEPS - delay * RATE) + ahead, 0)]
            held = held + (wanted - held) * (1 - math.exp(-h / max(lag, 1e-4)))
            spring = k * (held - q + offset)
            torque = np.clip(spring - d * w, -limit, limit) if within else np.clip(spring, -limit, limit) - d * w
            free = w + h * (torque - viscous * w - weight * MASS * 9.8 * RADIUS * np.cos(q)) / inertia
            w = np.sign(free) * np.maximum(np.abs(free) - h * coulomb / inertia, 0)
            q = q + h * w
    return out


def main() -> None:
    """Fit the four models and print them."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("fetched", type=Path, help="folder of fetch_real_robots.py")
    folder: Path = parser.parse_args().fetched
    command, position = experiments(folder)
    measured = np.isfinite(position)
    for where, first in STARTS.items():
        for n in (len(NAMES) - 1, len(NAMES)):

            def errors(free: np.ndarray, where: str = where) -> np.ndarray:
                numbers = np.concatenate([free, [1.0] * (len(NAMES) - len(free))])
                found = simulated(command, numbers, where.startswith("within"))
                return np.asarray((np.clip(np.nan_to_num(found, nan=9), -9, 9) - position)[measured])

            low, high = LOWEST[:n], HIGHEST[:n]
            start = np.clip(first[:n], low + 1e-6, high - 1e-6)
            scale = np.maximum(np.abs(start), 0.01)
            found = least_squares(errors, start, bounds=(low, high), x_scale=scale, diff_step=1e-3, max_nfev=40)
            numbers = ", ".join(f"{name} {value:.3g}" for name, value in zip(NAMES, found.x))
            print(f"brake {where}: {np.sqrt(np.mean(found.fun**2)):.3f} rad rms: {numbers}", flush=True)


if __name__ == "__main__":
    main()
