"""Least squares of free runs of the XL330: python docs/results/programs/measured/xl330_free_runs.py FETCHED.

It gives what real_robots.md calls known of that robot. A servo with its pendulum is simulated through each log from its
first position, without our diagnosis, and its numbers are fitted to the measured positions: with friction that the load
does not change, and with one in proportion to the torque that the gear transmits. FETCHED is the folder of
fetch_real_robots.py.
"""

from __future__ import annotations

import argparse
import json
import math
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

LOGS = {"sin_sin": "10h29m14", "sin_time_square": "10h29m37", "up_and_down": "10h29m29"}
MASS, LENGTH, GRAVITY = 0.49, 0.1, 9.81  # kg, m, m/s2
SUBSTEPS = 4
NAMES = ("stiffness", "limit", "viscous", "rotor", "offset", "delay", "coulomb", "share")
"""Numbers of the servo [Nm/rad, Nm, Nm s/rad, kg m2, rad, s, Nm, 1]."""
FIRST = np.array([0.9, 0.7, 0.04, 0.0015, 0.01, 0.006, 0.02, 0.3])
LOWEST = np.array([0.1, 0.2, 0.0, 1e-4, -0.3, 0.0, 0.0, 0.0])
HIGHEST = np.array([6.0, 5.0, 0.5, 0.02, 0.3, 0.03, 0.5, 1.0])


@dataclass(frozen=True, eq=False)
class Run:
    """A log: times [s], measured positions and commands [rad]."""

    time: list[float]
    position: np.ndarray
    command: list[float]


def run(folder: Path, stamp: str) -> Run:
    """Read a log."""
    text = (folder / f"bam/bam/data.bak/raw/2026-01-15_{stamp}.json").read_text()
    rows = json.loads(text)["entries"]
    columns = [[float(row[key]) for row in rows] for key in ("timestamp", "position", "goal_position")]
    return Run(columns[0], np.array(columns[1]), columns[2])


def simulated(log: Run, numbers: np.ndarray) -> np.ndarray:
    """Simulate a log from its first position at rest."""
    stiffness, limit, viscous, rotor, offset, delay, coulomb, share = numbers.tolist()
    arm = MASS * LENGTH**2
    q, w, carried = float(log.position[0]), 0.0, 0.0
    out = np.full(len(log.time), q)
    for n, (begin, end) in enumerate(zip(log.time, log.time[1:]), start=1):
        h = (end - begin) / SUBSTEPS
        for step in range(SUBSTEPS):
            held = log.command[max(bisect_right(log.time, begin + step * h - delay) - 1, 0)]
            weight = MASS * GRAVITY * LENGTH * math.sin(q)
            torque = min(max(stiffness * (held - q - offset), -limit), limit) - viscous * w - weight
            free = w + h * torque / (arm + rotor)
            stopped = h * (coulomb + share * abs(carried)) / (arm + rotor)
            after = math.copysign(max(abs(free) - stopped, 0.0), free)
            carried = arm * (after - w) / h + weight
            w = after
            q += h * w
        out[n] = q
    return out


def main() -> None:
    """Fit both frictions to each log and to all, and print the numbers."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("fetched", type=Path, help="folder of fetch_real_robots.py")
    folder: Path = parser.parse_args().fetched
    logs = {name: run(folder, stamp) for name, stamp in LOGS.items()}
    for law, n in (("no load", len(NAMES) - 1), ("load", len(NAMES))):
        for chosen in (*([name] for name in logs), list(logs)):

            def errors(free: np.ndarray, chosen: list[str] = chosen) -> np.ndarray:
                numbers = np.concatenate([free, np.zeros(len(NAMES) - len(free))])
                parts = [simulated(logs[name], numbers) - logs[name].position for name in chosen]
                return np.asarray(np.clip(np.nan_to_num(np.concatenate(parts), nan=9), -9, 9))

            found = least_squares(
                errors, FIRST[:n], bounds=(LOWEST[:n], HIGHEST[:n]), x_scale=FIRST[:n], diff_step=1e-3, max_nfev=40
            )
            numbers = ", ".join(f"{name} {value:.3g}" for name, value in zip(NAMES, found.x))
            rms = 1e3 * np.sqrt(np.mean(found.fun**2))
            print(f"friction with {law}, {', '.join(chosen)}: {rms:.0f} mrad rms: {numbers}", flush=True)


if __name__ == "__main__":
    main()
