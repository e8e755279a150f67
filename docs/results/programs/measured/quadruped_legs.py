"""Legs of a quadruped robot as arms on a fixed base: logs of each leg, and an MJCF of it with the servos of the log."""

from __future__ import annotations

import io
import pickle
import zipfile
from collections import OrderedDict
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

LEGS = ("FL", "FR", "RL", "RR")
JOINTS = {"hip": 23.7, "thigh": 23.7, "calf": 45.43}
"""Joints of a leg with their torque limits by the MJCF [Nm]."""
STIFFNESS, DAMPING = 20.0, 1.5
"""Gains of the servos by config.py of the repository [Nm/rad, Nm s/rad]."""
RATE = 200
"""Samples of the log in a second, by config.py."""
REPOSITORY = "sim2real-robot-identification"
LOG, MODEL = "datasets/go2/traj_0.pt", "robot_model/go2/go2.xml"


def assemble_go2(folder: Path) -> None:
    """Put commanded and measured positions of each leg into a CSV file, and write its MJCF, where they are there.

    Args:
        folder: The folder of the files of all repositories.
    """
    here = folder / REPOSITORY
    if not ((here / LOG).is_file() and (here / MODEL).is_file()):
        return
    log = tensors((here / LOG).read_bytes())
    names = ",".join(("time", *(f"{quantity}_{k}" for quantity in ("position", "command") for k in (1, 2, 3))))
    for number, leg in enumerate(LEGS):
        own = slice(3 * number, 3 * number + 3)
        rows = np.hstack([log["dof_pos"][:, own], log["des_dof_pos"][:, own]])
        lines = [f"{k / RATE:.3f}," + ",".join(f"{value:.8f}" for value in row) for k, row in enumerate(rows)]
        (here / f"{leg}.csv").write_text("\n".join((names, *lines)) + "\n")
        (here / f"{leg}.xml").write_text(leg_mjcf((here / MODEL).read_text(encoding="utf-8"), leg), encoding="utf-8")


def leg_mjcf(text: str, leg: str) -> str:
    """Return one leg of the MJCF on its fixed body, with a position actuator at each joint.

    Args:
        text: The MJCF of the robot.
        leg: One of `LEGS`.
    """
    root = ElementTree.fromstring(text)  # noqa: S314 - its checksum is that of the fetched file
    for name in ("asset", "sensor", "keyframe"):
        _without(root, lambda one, name=name: one.tag == name)
    option = root.find("option")
    assert option is not None
    option.set("timestep", f"{1 / RATE}")
    base = root.find("worldbody/body")
    assert base is not None
    _without(base, lambda one: one.tag != "body" or one.get("name") != f"{leg}_hip")
    for body in base.iter("body"):
        _without(body, lambda one: one.tag == "geom")
    for default in root.iter("default"):
        _without(default, lambda one: one.tag == "motor")
    actuators = root.find("actuator")
    assert actuators is not None
    _without(actuators, lambda one: True)
    for joint, limit in JOINTS.items():
        gains = {"kp": f"{STIFFNESS:g}", "kv": f"{DAMPING:g}", "forcerange": f"{-limit} {limit}"}
        names = {"name": f"{leg}_{joint}", "joint": f"{leg}_{joint}_joint"}
        ElementTree.SubElement(actuators, "position", names | gains)
    return ElementTree.tostring(root, encoding="unicode")


def _without(parent: ElementTree.Element, unwanted: Any) -> None:
    for one in [child for child in parent if unwanted(child)]:
        parent.remove(one)


def tensors(content: bytes) -> dict[str, np.ndarray]:
    """Read a dictionary of contiguous float tensors that PyTorch saved, without PyTorch.

    Args:
        content: The file.

    Raises:
        pickle.UnpicklingError: It holds anything else.
    """
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        (index,) = (name for name in archive.namelist() if name.endswith("/data.pkl"))
        found: dict[str, np.ndarray] = _Tensors(archive, index.partition("/")[0]).load()
    return found


class _Tensors(pickle.Unpickler):
    """Builds tensors as arrays, and nothing else."""

    def __init__(self, archive: zipfile.ZipFile, folder: str) -> None:
        super().__init__(io.BytesIO(archive.read(f"{folder}/data.pkl")))
        self._archive, self._folder = archive, folder

    def persistent_load(self, pid: Any) -> np.ndarray:
        return np.frombuffer(self._archive.read(f"{self._folder}/data/{pid[2]}"), "<f4")

    def find_class(self, module: str, name: str) -> Any:
        allowed = {
            ("torch._utils", "_rebuild_tensor_v2"): _tensor,
            ("torch", "FloatStorage"): "float",
            ("collections", "OrderedDict"): OrderedDict,
        }
        if (module, name) not in allowed:
            raise pickle.UnpicklingError(f"{module}.{name} is no part of a tensor")
        return allowed[module, name]


def _tensor(storage: np.ndarray, begin: int, shape: Sequence[int], *_: Any) -> np.ndarray:
    return storage[begin : begin + int(np.prod(shape))].reshape(shape)
