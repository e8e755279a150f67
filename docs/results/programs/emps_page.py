"""Write emps.md, on the measured drive: FLEXROS_REALDATA=... python docs/results/programs/emps_page.py [FOLDER]."""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from emps_flexibility import flexibility
from scipy.signal import butter, filtfilt

from flexros.effects import RobotWithEffects, parse_effect
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.settings import DiagnosisSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.robot import load_robot
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.result import DiagnosisResult
    from flexros.record.record import Record

POSITION_GAIN, SPEED_GAIN, FORCE_PER_VOLT, LIMIT = 160.18, 243.45, 35.1506, 351.506
"""Controller of the authors: 1/s, V s/m, N/V, N."""
NOISE = 5e-7
"""Noise of simulated positions [m]: the residuals after friction are then as large as in the measured log."""
HEAD = """# A measured drive: EMPS

Written by `FLEXROS_REALDATA=<folder with emps/> python docs/results/programs/emps_page.py`.
The data (Janot, Gautier and Brunot
2019) are not part of this repository. Model: `emps`, mass and viscous friction only. Two thirds of each log are fitted,
the last third is held out.
"""
ERRORS = """
## Errors in closed loop

Both experiments are simulated again from their beginning, with the controller of the authors, with the nominal model
and with the repaired model of the first log. Force: relative to the recorded one, unfiltered. Position: root mean
square. Acceleration: relative, after a zero-phase low-pass filter of 100 Hz.

| log | model | force [%] | position [um] | acceleration [%] |
|---|---|---|---|---|
"""
PUBLISHED = """
For comparison, from the notes with the data, in force for the first log and the pulses, and in position for the first
log: a linear model with fitted friction 17.3 and 16.8 %, 6.7 um; symmetric Coulomb friction 5.15 and 6.06 %, 1.74 um;
asymmetric friction 4.45 and 5.51 %, 1.40 um. The authors give for the symmetric one 5.848 and 8.9409 % in force, 8.6
and 19.8 % in acceleration, with their own filters.
"""


@dataclass(frozen=True)
class Experiment:
    """A log with what its controller was given.

    Attributes:
        record: The log.
        pulses: Force added to the command [N], shape (n,).
    """

    record: Record
    pulses: FloatArray

    def run(self, model: RobotWithEffects, noise: float = 0.0) -> Record:
        """Run the experiment again in closed loop.

        Args:
            model: Model of the drive.
            noise: Standard deviation of noise that is added to the recorded positions [m].

        Returns:
            The record with positions and forces of the run.
        """
        assert self.record.reference is not None
        reference, T = self.record.reference[:, 0], self.record.sample_time
        before = last = self.record.position[0, 0]
        plant = Plant(model.robot, T, np.array([last, 0.0]), laws=model.laws, substeps=2)
        rows = []
        for target, pulse in zip(reference, self.pulses):
            q = plant.measure()[0]
            volt = SPEED_GAIN * (POSITION_GAIN * (target - q) - (q - before) / (2 * T))
            force = float(np.clip(FORCE_PER_VOLT * volt + pulse, -LIMIT, LIMIT))
            before, last = last, q
            rows.append((q, force))
            plant.advance([force])
        position, torque = np.array(rows).T[:, :, None]
        position = position + noise * np.random.default_rng(1).normal(size=position.shape)
        return replace(self.record, position=position, torque=torque)

    def errors(self, model: RobotWithEffects) -> tuple[float, float, float]:
        """Compare a run with the log.

        Args:
            model: Model of the drive.

        Returns:
            Errors of force [%], position [um] and acceleration [%].
        """
        ours, theirs = self.run(model), self.record
        inner = slice(300, -300)
        ratio = [np.linalg.norm((a - b)[inner]) / np.linalg.norm(b[inner]) for a, b in _pairs(ours, theirs)]
        off = (ours.position - theirs.position)[inner]
        return 100 * float(ratio[0]), 1e6 * float(np.sqrt(np.mean(off**2))), 100 * float(ratio[1])


def _pairs(ours: Record, theirs: Record) -> list[tuple[FloatArray, FloatArray]]:
    """Pair the forces and the accelerations of two logs."""
    return [(ours.torque[:, 0], theirs.torque[:, 0]), (_acceleration(ours), _acceleration(theirs))]


def _acceleration(record: Record) -> FloatArray:
    low = butter(4, 100.0, fs=1 / record.sample_time)
    smooth = filtfilt(*low, record.position[:, 0])
    result: FloatArray = np.gradient(np.gradient(smooth, record.sample_time), record.sample_time)
    return result


def experiment(path: Path) -> Experiment:
    """Read a log.

    Args:
        path: MATLAB file of the authors.
    """
    log = import_log(load_mapping("emps"), [path])
    record = checked_log(log, load_robot("emps"), name=path.stem)
    assert log.joint_reference is not None
    effort = log.joint_reference.effort
    return Experiment(record, np.zeros(record.n_samples) if effort is None else effort[:, 0])


def _section(name: str, result: DiagnosisResult) -> str:
    """Write the section on the diagnosis of a log."""
    diagnosis = result.diagnosis
    closed = diagnosis.gap.closed_fraction
    lines = [
        f"\n## {name}: {diagnosis.verdict}, {'-' if closed is None else f'{100 * closed:.1f} %'} of the gap closed on "
        "held-out data\n\n| cause | probability | parameters | closed alone |\n|---|---|---|---|\n"
    ]
    for cause in diagnosis.causes:
        parameters = ", ".join(
            f"{key} {value.value:.4g} ± {value.std:.2g} {value.unit}" for key, value in cause.parameters.items()
        )
        alone = "-" if cause.closed_fraction is None else f"{100 * cause.closed_fraction:.1f} %"
        lines.append(
            f"| `{cause.effect}@{cause.location}` | {100 * cause.probability:.2f} % | {parameters} | {alone} |\n"
        )
    candidates = [f"{candidate.effect}@{candidate.location}" for candidate in result.ranking[:6]]
    lines.append(f"\nFirst six of the ranking: {', '.join(candidates)}.\n")
    return "".join(lines)


def page(folder: Path) -> str:
    """Write the page.

    Args:
        folder: Folder with the files of the authors.

    Returns:
        Its text in Markdown.
    """
    nominal = RobotWithEffects(load_robot("emps"), ())
    settings = DiagnosisSettings(where=None, next_experiment=None)
    names = ("DATA_EMPS", "DATA_EMPS_PULSES")
    runs = {name: experiment(folder / f"{name}.mat") for name in names}
    results = {name: diagnose(run.record, nominal, settings=settings) for name, run in runs.items()}
    parts = [HEAD, *[_section(name, result) for name, result in results.items()], ERRORS]
    repaired = nominal.with_effects(results["DATA_EMPS"].patch)
    late = repaired.with_effects([parse_effect("delay@all:time=3e-4", "this page")])
    models = {"nominal": nominal, "diagnosed": repaired, "diagnosed, forces 0.3 ms later": late}
    for name, run in runs.items():
        for label, model in models.items():
            parts.append(f"| {name} | {label} | " + " | ".join(f"{x:.2f}" for x in run.errors(model)) + " |\n")
    pulses = runs["DATA_EMPS_PULSES"]
    parts.append(PUBLISHED)
    parts.append(flexibility(pulses.record, pulses.pulses, lambda model: pulses.run(model, NOISE), repaired))
    return "".join(parts)


def main() -> None:
    """Write the page."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[1], help="folder of the page")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "emps.md").write_text(page(Path(os.environ["FLEXROS_REALDATA"]) / "emps"), encoding="utf-8")


if __name__ == "__main__":
    main()
