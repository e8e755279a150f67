"""The steps of one case of real_robots.md; what is done is kept in a JSON file, so that a run can be resumed."""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from real_robots_mujoco import ABSENT, identified

from flexros.effects import parse_effect, place_effects
from flexros.effects.patching.patched_robot import load_model, load_patched
from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.held_out.split import split
from flexros.gap.measure_gap import measure_gap
from flexros.gap.settings import DiagnosisSettings
from flexros.json_text import json_text
from flexros.logs.reader import read_log
from flexros.logs.write_log import write_log
from flexros.provenance import code_version, versions
from flexros.robot import load_robot

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from real_robots_case import Case

    from flexros.effects import RobotWithEffects
    from flexros.logs.time_series import Log
    from flexros.record.record import Record

FLEXROS = (sys.executable, "-c", "import sys; from flexros.cli import main; sys.exit(main())")
GAP_FOUND = 1
"""Exit code of a diagnosis that found a gap."""
UNFINISHED = "not finished"
"""Verdict of a diagnosis that took too long."""
REST = "last third"
"""Name of the part that is not fitted where there is one log alone."""


@dataclass(frozen=True)
class Used:
    """What a command used.

    Attributes:
        seconds: Its time [s].
        cpu_seconds: Time of the processors [s].
        memory: Its largest memory [GB].
        ended: Whether it ended by itself.
    """

    seconds: float
    cpu_seconds: float = 0.0
    memory: float = 0.0
    ended: bool = False


def _largest_memory(pid: int) -> float:
    """Return the largest memory of a running process so far [GB]; zero for one that has ended.

    What `os.wait4` states includes this process at the time of the fork, which fits by MuJoCo may have made large.
    """
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(found.group(1)) * 1024 / 1e9 if found else 0.0


@dataclass(frozen=True)
class Run:
    """One case in a folder of its own.

    Attributes:
        case: The case.
        data: Folder of its data.
        work: Folder for logs, robot files and diagnosis.
        result: The JSON file.
        limit: Time after which a diagnosis is partial [s].
        patience: Factor of that time after which it is ended from outside [1].
    """

    case: Case
    data: Path
    work: Path
    result: Path
    limit: float
    patience: float = 2.0

    @cached_property
    def found(self) -> dict[str, Any]:
        """What is known so far."""
        if self.result.is_file():
            content: dict[str, Any] = json.loads(self.result.read_text(encoding="utf-8"))
            return content
        return {"case": self.case.name}

    def all_steps(self) -> None:
        """Do what is not done yet, and keep each step as soon as it is done."""
        self.work.mkdir(parents=True, exist_ok=True)
        self._step("versions", lambda: {"code": code_version(), **versions()})
        for name, files in {"fitted": self.case.fitted, **self.case.further}.items():
            self._import(name, files)
        self._step("diagnosis", self.diagnosis)
        if self.found.get("least_squares", {}).get("friction") and not (self.work / "rigid").is_dir():
            del self.found["least_squares"]  # the robot that it identified is in the folder of another run
        self._step("least_squares", self.least_squares)
        if self.found.get("mujoco", {}).get("skipped") in ABSENT:  # it may have been installed since
            del self.found["mujoco"]
        self._step("mujoco", self.mujoco)
        for name, record in self._not_fitted().items():
            for way, model in self._repairs().items():
                self._step(f"logs.{name}.{way}", partial(self._gap, record, model))

    def _step(self, key: str, make: Callable[[], Any]) -> None:
        node, *parts = self.found, *key.split(".")
        for part in parts[:-1]:
            node = node.setdefault(part, {})
        if parts[-1] in node:
            return
        print(f"{self.case.name}: {key}", flush=True)
        node[parts[-1]] = make()
        self.result.parent.mkdir(parents=True, exist_ok=True)
        self.result.write_text(json_text(self.found), encoding="utf-8")

    @cached_property
    def robot(self) -> str:
        """Name or file of the nominal robot; a URDF or MJCF is converted."""
        given = self.case.path(self.case.robot, self.data)
        command = {".urdf": "import-urdf", ".xml": "import-mjcf"}.get(Path(given).suffix)
        if command is None:
            return given
        made = self.work / "robot.yaml"
        if not made.is_file():
            self._command(command, given, "--out", str(made))
        return str(made)

    @cached_property
    def nominal(self) -> RobotWithEffects:
        """The nominal model."""
        return load_model(self.robot)

    def _import(self, name: str, files: Sequence[str]) -> None:
        folder = self.work / name
        if folder.exists():
            return
        paths = [str(self.data / file) for file in files]
        mapping = self.case.path(self.case.mapping, self.data)
        self._command("import", mapping, *paths, "--out", str(folder))
        if name == "fitted" and not self.case.further:  # least squares must not see the last third
            write_log(first_part(read_log(folder), DiagnosisSettings().fitted_share), self.work / "first")

    def _command(self, *arguments: str, expected: Sequence[int] = (0,), limit: float | None = None) -> Used:
        """Run a command of FlexROS; its output is kept."""
        printed = self.work / f"{arguments[0]}.txt"
        began = time.monotonic()
        with printed.open("w", encoding="utf-8") as output:
            process = subprocess.Popen([*FLEXROS, *arguments], stdout=output, stderr=output)  # noqa: S603 - our own program
        ended, status, usage, memory = 0, 0, resource.getrusage(resource.RUSAGE_SELF), 0.0
        try:
            while not ended and (limit is None or time.monotonic() - began < limit):
                time.sleep(0.05)
                memory = max(memory, _largest_memory(process.pid))
                ended, status, usage = os.wait4(process.pid, os.WNOHANG)
        finally:
            if not ended:
                process.kill()
                process.wait()
        if not ended:
            return Used(time.monotonic() - began)
        process.returncode = code = os.waitstatus_to_exitcode(status)
        if code not in expected:
            said = printed.read_text(encoding="utf-8").strip().splitlines() or ["nothing"]
            raise InputError(f"flexros {arguments[0]} ended with {code}: {said[-1].removeprefix('flexros: ')}")
        return Used(time.monotonic() - began, usage.ru_utime + usage.ru_stime, memory, ended=True)

    def diagnosis(self) -> dict[str, Any]:
        """Diagnose the fitted log in a process of its own, with its time and memory."""
        folder = self.work / "diagnosis"
        arguments = ("diagnose", str(self.work / "fitted"), "--model", self.robot, "--out", str(folder))
        limit = ("--time-limit", f"{self.limit:g}")
        without = ("--prescribed", ",".join(self.case.prescribed)) if self.case.prescribed else ()
        used = self._command(*arguments, *limit, *without, expected=(0, GAP_FOUND), limit=self.patience * self.limit)
        if not used.ended:
            return {"verdict": UNFINISHED, "seconds": used.seconds}
        answer: dict[str, Any] = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
        kept = (
            *("verdict", "partial", "causes", "ambiguity_groups", "tolerance_sensitivity", "model_numbers"),
            *("gap", "budget", "unexplained", "warnings"),
        )
        return {
            **{key: answer[key] for key in kept if key in answer},
            "seconds": used.seconds,
            "cpu_seconds": used.cpu_seconds,
            "cores": os.cpu_count(),
            "largest_memory_gb": used.memory,
        }

    def least_squares(self) -> dict[str, Any]:
        """Identify the rigid model with Coulomb and viscous friction by linear regression."""
        folder, log = self.work / "rigid", self._log_of_fits()
        cutoff = ("--cutoff", f"{self.case.cutoff:g}") if self.case.cutoff else ()
        try:
            self._command("identify", "rigid", str(log), "--model", self.robot, "--out", str(folder), *cutoff)
            refused = ""
        except InputError as error:
            refused = str(error).partition(": ")[2]
        if not (folder / "rigid.json").is_file():
            return {"refused": refused, "friction": {}, "effects": []}
        answer = json.loads((folder / "rigid.json").read_text(encoding="utf-8"))
        friction = {
            row["name"]: {key: row[key] for key in ("value", "std", "unit")}
            for row in answer["parameters"]
            if "friction" in row["name"]
        }
        return {
            "refused": refused,
            "torque_error_percent": answer["force_error_percent"]["fit"]["total"],
            "friction": friction,
            "effects": answer["not_in_robot_file"]["effects"],
        }

    def mujoco(self) -> dict[str, Any]:
        """Identify damping, dry friction and armature with the toolbox of MuJoCo."""
        if self.case.by_mujoco:
            return {"skipped": self.case.by_mujoco}
        record = self._record("fitted")
        return identified(split(record, DiagnosisSettings().fitted_share)[0], self.robot)

    def _log_of_fits(self) -> Path:
        return self.work / ("fitted" if self.case.further else "first")

    def _record(self, name: str) -> Record:
        log, prescribed = read_log(self.work / name), self.case.prescribed
        return checked_log(log, self.nominal.robot, name=name, prescribed=prescribed)

    def _not_fitted(self) -> dict[str, Record]:
        if self.case.further:
            return {name: self._record(name) for name in self.case.further}
        return {REST: split(self._record("fitted"), DiagnosisSettings().fitted_share)[1]}

    def _repairs(self) -> dict[str, RobotWithEffects | None]:
        """Collect the repaired models by the way in which they were found; None where there is none."""
        patch = self.work / "diagnosis" / "patch.yaml"
        base, found = load_robot(self.robot), self.found
        models: dict[str, RobotWithEffects | None] = {}
        if found["diagnosis"]["verdict"] != UNFINISHED:
            models["diagnosis"] = load_patched(patch).model if patch.is_file() else None
        if self.case.by_hand:
            models["hand"] = repaired(self.robot, self.case.numbers_by_hand, self.case.by_hand)
        squares = found["least_squares"]
        if squares["friction"]:
            identified_robot = self.work / "rigid" / "identified.yaml"
            viscous = {
                name: max(row["value"], 0.0)
                for name, row in squares["friction"].items()
                if name.endswith("viscous_friction") and name in base.parameters
            }
            robot, numbers = (str(identified_robot), {}) if identified_robot.is_file() else (self.robot, viscous)
            models["least_squares"] = repaired(robot, numbers, squares["effects"])
        if "effects" in found["mujoco"]:
            models["mujoco"] = repaired(self.robot, found["mujoco"]["numbers"], found["mujoco"]["effects"])
        return models

    def _gap(self, record: Record, model: RobotWithEffects | None) -> dict[str, Any]:
        if model is None:  # nothing was found, so nothing is repaired
            return {"closed_fraction": 0.0}
        return measure_gap(record, self.nominal, repaired=model).numbers.model_dump(mode="json")


def repaired(robot: str, numbers: Mapping[str, float], effects: Sequence[str]) -> RobotWithEffects:
    """Change numbers of a robot and put effects on it.

    Args:
        robot: Built-in robot or robot file.
        numbers: New values by name of the parameter [SI].
        effects: Effects as NAME@LOCATION:parameter=value.
    """
    changed = load_robot(robot).with_values(dict(numbers), "the repair") if numbers else load_robot(robot)
    return place_effects(changed, [parse_effect(text, "the repair") for text in effects])


def first_part(log: Log, share: float) -> Log:
    """Cut a log after a share of its time [1]."""
    stamps = log.joint_states.stamp
    end = stamps[0] + share * (stamps[-1] - stamps[0])

    def cut(series: Any) -> Any:
        if series is None:
            return None
        kept, n = series.stamp <= end, len(series.stamp)
        changed = {
            name: value[kept]
            for name, value in vars(series).items()
            if hasattr(value, "shape") and value.ndim and len(value) == n
        }
        return replace(series, **changed)

    return replace(
        log,
        joint_states=cut(log.joint_states),
        joint_commands=cut(log.joint_commands),
        joint_reference=cut(log.joint_reference),
        other_series={name: cut(series) for name, series in log.other_series.items()},
    )
