"""Write kinematic_identification.md, on simulated robots: python docs/results/programs/kinematic_identification.py."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from flexros.identify.kinematics.design import candidate_poses, optimal_poses
from flexros.identify.kinematics.elastostatics import measured_points
from flexros.identify.kinematics.fit import fit_kinematics
from flexros.identify.kinematics.record import PoseRecord
from flexros.identify.kinematics.unknowns import unknowns
from flexros.robot import load_robot

NOISE, LOADS, DRAWS = 5e-5, (0.0, 100.0, 200.0), 6
PLANNED, OTHER = 60, 100
HEAD = f"""# Lengths, zeros and compliances from tracker poses

Written by `python docs/results/programs/kinematic_identification.py`.
Robot `six_axis`; in each row its lengths, zeros, mounting
angles and compliances are drawn from the prior of the fit. {PLANNED} planned poses with loads of 0, 100 and 200 kg and
tracker noise of {1e3 * NOISE:g} mm (rms per coordinate) are fitted; the distances are those in {OTHER} other poses
without noise. The poses follow from the elastostatic model of the fit, which is the equilibrium of the plant within
1e-9 m (a test). A real robot adds what is in neither.

| draw | before: mean [mm] | largest [mm] | after: mean [mm] | largest [mm] | true numbers in their 95 % intervals |
|---|---|---|---|---|---|
"""


def main() -> None:
    """Identify robots that are drawn at random, and write the page."""
    assert __doc__ is not None
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    unknown = unknowns(load_robot("six_axis"))
    candidates = candidate_poses(unknown, LOADS, 200)
    poses = candidates.rows(optimal_poses(unknown, candidates, PLANNED, NOISE))
    others = candidate_poses(unknown, LOADS, OTHER, seed=9)
    rows, inside = [], []
    for draw in range(1, DRAWS + 1):
        rng = np.random.default_rng(draw)
        theta = rng.normal(size=len(unknown.names)) * unknown.deviation
        points, _ = measured_points(unknown, poses, theta)
        noisy = PoseRecord(poses.motor_position, poses.load, points + NOISE * rng.normal(size=points.shape))
        fit = fit_kinematics(unknown, noisy, NOISE)
        elsewhere = PoseRecord(others.motor_position, others.load, measured_points(unknown, others, theta)[0])
        before, after = (1e3 * fit.errors(elsewhere, nominal=nominal) for nominal in (True, False))
        inside.append(np.abs(fit.theta - theta) < 1.96 * fit.deviations)
        sizes = " | ".join(f"{one:.3g}" for one in (before.mean(), before.max(), after.mean(), after.max()))
        rows.append(f"| {draw} | {sizes} | {np.mean(inside[-1]):.0%} of {len(theta)} |")
    total = f"\nTogether {np.mean(inside):.1%} of {np.size(inside)} numbers lie in their 95 % intervals.\n"
    (Path(__file__).parents[1] / "kinematic_identification.md").write_text(HEAD + "\n".join(rows) + "\n" + total)


if __name__ == "__main__":
    main()
