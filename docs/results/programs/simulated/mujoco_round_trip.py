"""Write mujoco_round_trip.md: python docs/results/programs/simulated/mujoco_round_trip.py [FOLDER].

FLEXROS_REALDATA names the folder of the measured data.

The log DIAGNOSED is diagnosed twice, with different held-out data, which takes some minutes.
"""

from __future__ import annotations

import argparse
import os
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
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray

DATA = "dfki_double_pendulum"
NOMINAL, PUBLISHED = "robot_without_friction.yaml", "patch_published.yaml"
DIAGNOSED, HOLDOUT = "C_143601", "C_143339"
LOGS = (DIAGNOSED, HOLDOUT, "C_143524", "C_143906", "C_144115")
WINDOWS = (0.1, 0.5)
"""Durations of the runs [s], each from a measured state."""

HEAD = """# Round trip: measured log, patch, MuJoCo

Written by `python docs/results/programs/simulated/mujoco_round_trip.py`, where FLEXROS_REALDATA names a folder with
dfki_double_pendulum. The data
(DFKI double pendulum, design C.1, 500 Hz, 10 s each; BSD-3-Clause) are not part of this repository.

The nominal robot file, rigid and without friction, is exported by `flexros export ROBOT --to mjcf`. Patches are then
written into that file by `flexros export PATCH --to mjcf --base nominal.xml`. MuJoCo runs over each log in windows from
the measured positions and speeds, with the recorded commands held; the figures are rms errors of the positions over all
samples, in mrad. The published friction is that of the authors' identification. The diagnosed ones are the patches of
`flexros diagnose` with {log} at the time this page was written: A with the last third of that log held out, B with
`--holdout {holdout}`. {holdout} is not fitted by either, but B's answer depends on it. The other logs were used by
neither.

{patches}
"""
TABLE = """
## Windows of {window:g} s

| log | joint | nominal | {names} |
|---|---|---|{rules}|
"""
SOFT = """
## MuJoCo's dry friction

`frictionloss` is a constraint, not a torque: at standstill it creeps, with the time constant in `solreffriction`. With
the published patch and windows of {window:g} s, the rms errors over all logs, both joints together, are
{default:.2f} mrad with MuJoCo's default of 20 ms and {short:.2f} mrad with two time steps, as in a new file of
`flexros export`. On these logs, which hardly stand still, the difference does not matter.
"""


@dataclass(frozen=True, eq=False)
class Recorded:
    """A log of two joints.

    Attributes:
        time: Instants of the samples [s], shape (n,).
        position: Measured positions [rad], shape (n, 2).
        speed: Measured speeds [rad/s], shape (n, 2).
        torque: Commanded torques [Nm], shape (n, 2).
    """

    time: FloatArray
    position: FloatArray
    speed: FloatArray
    torque: FloatArray


def read(file: Path) -> Recorded:
    """Read a log of the double pendulum."""
    table = np.genfromtxt(file, delimiter=",", names=True)

    def pair(name: str) -> FloatArray:
        return np.column_stack([table[f"{name}{joint}"] for joint in (1, 2)])

    return Recorded(table["time"], pair("pos_meas"), pair("vel_meas"), pair("tau_con"))


def errors(model: Any, log: Recorded, window: float) -> FloatArray:
    """Return the rms errors of the positions [rad] over windows of a log, shape (2,).

    Args:
        model: The model, mujoco.MjModel.
        log: The log.
        window: Duration of each run [s].
    """
    data, step = mujoco.MjData(model), model.opt.timestep
    found = []
    for start in np.searchsorted(log.time, np.arange(log.time[0], log.time[-1] - window, window)):
        times = log.time[start] + step * np.arange(round(window / step) + 1)
        held = np.searchsorted(log.time, times + 1e-9, side="right") - 1
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = log.position[start], log.speed[start]
        run = np.empty((len(times) - 1, 2))
        for k in range(len(run)):
            data.ctrl[:] = log.torque[held[k]]
            mujoco.mj_step(model, data)
            run[k] = data.qpos
        measured = np.column_stack([np.interp(times[1:], log.time, log.position[:, joint]) for joint in range(2)])
        found.append(run - measured)
    rms: FloatArray = np.sqrt(np.mean(np.concatenate(found) ** 2, axis=0))
    return rms


def models_of(nominal: Path, patches: Mapping[str, Path], folder: Path) -> dict[str, Any]:
    """Return the nominal model and the repaired ones, compiled.

    Args:
        nominal: Robot file without effects.
        patches: Patches of it by name.
        folder: Folder for the files of MuJoCo.
    """
    base = folder / "nominal.xml"
    base.write_text(export_model(load_patched(nominal), "mjcf").text, encoding="utf-8")
    texts = {name: export_model(load_patched(patch), "mjcf", base).text for name, patch in patches.items()}
    return {
        "nominal": mujoco.MjModel.from_xml_path(str(base)),
        **{name: mujoco.MjModel.from_xml_string(text) for name, text in texts.items()},
    }


def diagnosed_patch(source: Path, folder: Path, holdout: str) -> Path:
    """Diagnose a log and return the patch that was written.

    Args:
        source: Folder of the data.
        folder: Folder for the files of the diagnosis; it is made.
        holdout: Name of the held-out log, empty for the last third of the log itself.
    """
    known = load_model(source / NOMINAL)
    mapping = load_mapping(str(source / "mapping.yaml"))
    names = [DIAGNOSED, *([holdout] if holdout else [])]
    logs = [import_log(mapping, [source / f"{name}.csv"]) for name in names]
    record, *others = [checked_log(log, known.robot, name=name) for log, name in zip(logs, names)]
    folder.mkdir()
    result = diagnose(record, known, holdout=others[0] if others else None, log=logs[-1])
    write_diagnosis(result, str(source / NOMINAL), folder)
    return folder / "patch.yaml"


def page(source: Path) -> str:
    """Write the page from the data of a folder."""
    logs = {name: read(source / f"{name}.csv") for name in LOGS}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        patches = {
            "published": source / PUBLISHED,
            "diagnosed A": diagnosed_patch(source, folder / "a", ""),
            "diagnosed B": diagnosed_patch(source, folder / "b", HOLDOUT),
        }
        models = models_of(source / NOMINAL, patches, folder)
        new = mujoco.MjModel.from_xml_string(export_model(load_patched(patches["published"]), "mjcf").text)
        listed = [f"- {name}: {_effects(file)}." for name, file in patches.items()]
    text = HEAD.format(log=DIAGNOSED, holdout=HOLDOUT, patches="\n".join(listed))
    for window in WINDOWS:
        text += TABLE.format(window=window, names=" | ".join(patches), rules="|".join("---" for _ in patches))
        for name, log in logs.items():
            found = {key: 1e3 * errors(model, log, window) for key, model in models.items()}
            text += _rows(name, found)
    shortest = WINDOWS[0]
    default, short = (
        1e3 * float(np.sqrt(np.mean([np.sum(errors(model, log, shortest) ** 2) for log in logs.values()])))
        for model in (models["published"], new)
    )
    return text + SOFT.format(window=shortest, default=default, short=short)


def _rows(log: str, found: Mapping[str, FloatArray]) -> str:
    rows = ""
    for joint in range(2):
        nominal, *others = (values[joint] for values in found.values())
        cells = " | ".join(f"{value:.2f} ({100 * (value / nominal - 1):+.0f} %)" for value in others)
        rows += f"| {log} | {joint + 1} | {nominal:.2f} | {cells} |\n"
    return rows


def _effects(patch: Path) -> str:
    parts = []
    for placed in load_patched(patch).placed:
        changed: Sequence[str] = [f"{key} {value:.4g}" for key, value in placed.effect.model_dump().items() if value]
        parts.append(f"{placed.effect.name} at {placed.location} ({', '.join(changed)})")
    return "; ".join(parts) or "no effect"


def main() -> None:
    """Write the page."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[2], help="folder of the page")
    folder = parser.parse_args().folder
    written = page(Path(os.environ["FLEXROS_REALDATA"]) / DATA)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mujoco_round_trip.md").write_text(written, encoding="utf-8")


if __name__ == "__main__":
    main()
