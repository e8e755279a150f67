"""What is to be seen of a log or of a diagnosis."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis import analyse
from flexros.config.settings import validate
from flexros.config.yaml_file import read_yaml
from flexros.effects.patching.patch import Patch, named_robot
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.report.colours import MEASURED, NOMINAL, REPAIRED
from flexros.robot.robot import robot_names
from flexros.view.motion import LENGTH, predicted_motion, robot_motion
from flexros.view.player import ArmOverTime, Shown
from flexros.view.scene import PathShown
from flexros.view.signals import signal_plots

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.analysis.path_error import PathError
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.logs.time_series import Log
    from flexros.view.motion import Motion


def is_diagnosis(path: Path) -> bool:
    """Return whether a folder is that of a diagnosis."""
    return (path / "diagnosis.json").is_file()


def is_log(path: Path) -> bool:
    """Return whether a path is a log rather than a robot."""
    return path.is_dir() or path.suffix in (".mcap", ".db3")


def shown_log(path: Path, model: str = "", *, namespace: str = "", first: float = 0.0, length: float = LENGTH) -> Shown:
    """Prepare the page of a log.

    Args:
        path: The log.
        model: Robot name, robot file or patch; empty for the robot in the provenance of the log.
        namespace: Namespace of its topics.
        first: Beginning of the part that is shown, since that of the log [s].
        length: Length of that part [s].

    Raises:
        InputError: The log cannot be read, or its robot is not known.
    """
    log = read_log(path, namespace=namespace or None)
    used = load_model(model or robot_of(log, path))
    motion = robot_motion(log, used, path.name, first, length)
    arms = (ArmOverTime(path.name, REPAIRED, motion.arm),)
    error = _path_error(log, used)
    return Shown(
        f"Log {path.name}",
        motion.note,
        used.robot,
        motion,
        arms,
        _path(error, motion),
        signal_plots(log, used.robot, motion, error),
    )


def shown_diagnosis(
    folder: Path,
    log_path: Path | None = None,
    model: str = "",
    *,
    first: float = 0.0,
    length: float = LENGTH,
    progress: Callable[[str, float], None] | None = None,
) -> Shown:
    """Prepare the page of a diagnosis: the robot, the nominal and the repaired model side by side.

    Args:
        folder: Folder of the diagnosis, with diagnosis.json and, where there is anything to repair, patch.yaml.
        log_path: The log; None to look for the one named in diagnosis.json beside the folder and here.
        model: Nominal model; empty for that of the patch, or without one for the built-in robot in diagnosis.json.
        first: Beginning of the part that is shown, since that of the log [s].
        length: Length of that part [s].
        progress: Called with the name of the stage and the share of all that is done.

    Raises:
        InputError: The folder holds no diagnosis, or log or robot cannot be loaded.
    """
    tell = progress or (lambda _what, _share: None)
    origin = _origin(folder)
    path = log_path or _log_beside(folder, str(origin.get("log", "")))
    tell("reading", 0.0)
    log = read_log(path)
    patch = folder / "patch.yaml"
    nominal = load_model(model or _nominal(patch, str(origin.get("robot", ""))))
    repaired = load_model(patch) if patch.is_file() else None
    tell("motion of the robot", 0.1)
    best = repaired or nominal
    motion = robot_motion(log, best, path.name, first, length)
    arms = [ArmOverTime("robot", MEASURED, motion.arm)]
    models = [("nominal model", NOMINAL, nominal), ("repaired model", REPAIRED, repaired)]
    predicted = []
    left_out = ""
    for index, (name, colour, known) in enumerate(models):
        if known is None or not motion.bent:
            continue
        tell(name, 0.4 + 0.3 * index)
        try:
            one = predicted_motion(log, known, motion, name=name, log_name=path.name, length=length)
        except InputError as fault:  # e.g. a nominal model without rotors, whose arm moves too fast
            left_out += f" The {name} is not drawn: {fault}."
            continue
        predicted.append(one)
        arms.append(ArmOverTime(name, colour, one.arm))
    error = _path_error(log, best)
    text = (
        f"{motion.note} The models predict the motion **0.1 s ahead** from the motor torques; the difference of each "
        f"from the robot has a magnification of its own.{left_out}"
    )
    plots = signal_plots(log, best.robot, motion, error, predicted)
    title = f"Diagnosis {folder.absolute().name}"
    return Shown(title, text, best.robot, motion, tuple(arms), _path(error, motion), plots)


def _origin(folder: Path) -> dict[str, object]:
    file = folder / "diagnosis.json"
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        origin: dict[str, object] = content["provenance"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{file} is no diagnosis ({error}); give a folder that `flexros diagnose` wrote") from None
    return origin


def _nominal(patch: Path, name: str) -> str:
    """Return the nominal model of a diagnosis: what its patch applies to, else the robot that it names."""
    if patch.is_file():
        return named_robot(validate(Patch, read_yaml(patch), str(patch)).robot, patch.parent)
    if name not in robot_names():
        raise InputError(f"the diagnosis has no patch and was made of the robot '{name}'; give its file", "model")
    return name


def _log_beside(folder: Path, name: str) -> Path:
    """Find the log of a diagnosis by its name."""
    places = [folder.absolute().parent, Path.cwd(), Path.cwd() / "bags"]
    found = next((place / name for place in places if name and (place / name).exists()), None)
    if found is None:
        looked = ", ".join(str(place) for place in dict.fromkeys(places))
        raise InputError(f"the log '{name}' of {folder} is not in {looked}; give its path", argument="log")
    return found


def robot_of(log: Log, path: Path) -> str:
    """Return the robot that the provenance of a log names.

    Args:
        log: The log.
        path: Its path, for messages.

    Raises:
        InputError: It names none.
    """
    scenario = log.provenance.get("scenario")
    name = scenario.get("robot") if isinstance(scenario, dict) else None
    if not isinstance(name, str):
        raise InputError(
            f"the provenance of {path} names no robot; give a robot name, a robot file or a patch", argument="model"
        )
    return name


def _path_error(log: Log, model: RobotWithEffects) -> PathError | None:
    """Return the tool error in two or three components of space; None where there is none."""
    if all(not np.any(body.length.value) for body in model.robot.spec.bodies):
        return None  # such a robot is drawn as bars above each other, which the path would not meet
    found = analyse(log, robot=model.robot).path
    return found if found is not None and len(found.axes) > 1 else None


def _path(error: PathError | None, motion: Motion) -> PathShown | None:
    if error is None:
        return None
    run = error.run
    inside: FloatArray = (run.time >= motion.time[0]) & (run.time <= motion.time[-1])
    if np.count_nonzero(inside) < 2:
        return None
    return PathShown(run.time[inside], error.nearest[inside], (run.attained - error.nearest)[inside])
