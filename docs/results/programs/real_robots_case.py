"""What the page of measured robots states of one of them: its data, nominal model, mapping, and what is known of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

OWN = Path(__file__).parent / "measured"
"""Mappings and robot files of data sets that have none."""
KINDS = {
    "Coulomb friction": (("coulomb_friction", "level"), ("presliding_friction", "level")),
    "load dependent friction": (("load_dependent_friction", "share"),),
    "viscous friction": (("viscous_friction", "coefficient"),),
    "asymmetric viscous friction": (("viscous_friction", "asymmetry"),),
    "inertia": (("rotor_inertia", "inertia"),),
    "servo stiffness": (),
}
"""Effects and parameters that state a known deviation."""
NUMBERS = {"viscous friction": "viscous_friction", "inertia": "inertia", "servo stiffness": "servo_stiffness"}
"""Last part of the name of a number of the robot that states it, where it is counted from zero."""


@dataclass(frozen=True)
class Known:
    """A deviation that is published or follows from least squares.

    Attributes:
        kind: One of `KINDS`.
        joint: Its motor.
        low: Smallest value stated, in `unit`.
        high: Largest value stated.
        unit: Its unit.
        nominal: The value in the robot file, from which an effect counts.
    """

    kind: str
    joint: str
    low: float
    high: float
    unit: str
    nominal: float = 0.0


@dataclass(frozen=True)
class Case:
    """A measured robot.

    Attributes:
        name: Name of the case and of its JSON file.
        title: Heading of its section.
        about: What it is, where it comes from, where its nominal model comes from.
        folder: Folder of its files in the folder of measured data, or in that of fetched data.
        robot: Built-in robot, robot file of the folder, or robot or URDF file among ours or in the folder.
        mapping: Built-in mapping or mapping file, as above.
        fitted: Files of the log that is fitted.
        further: Files of logs that are not fitted, by name.
        known: What is published of the gap.
        source: Where that comes from.
        by_hand: Effects of a hand-made patch; without, there is none.
        numbers_by_hand: Numbers of the robot file that it changes, by name [SI].
        cutoff: Low-pass of least squares [Hz], where that of the command does not do; zero: as the command chooses.
        by_mujoco: Why the toolbox of MuJoCo does not apply; empty where it does.
        fetched: Whether `fetch_real_robots.py` brings the files.
        prescribed: Motors without usable torques, whose measured motion drives the model in all logs.
        in_hindsight: Whether the fitted log was chosen with the answers in view: the case does not count.
    """

    name: str
    title: str
    about: str
    folder: str
    robot: str
    mapping: str
    fitted: tuple[str, ...]
    known: tuple[Known, ...]
    source: str
    further: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    by_hand: tuple[str, ...] = ()
    numbers_by_hand: Mapping[str, float] = field(default_factory=dict)
    cutoff: float = 0.0
    by_mujoco: str = ""
    fetched: bool = False
    prescribed: tuple[str, ...] = ()
    in_hindsight: bool = False

    def path(self, name: str, data: Path) -> str:
        """Return the path of a robot or mapping, of ours or in the folder of the data; a built-in name as it is."""
        if not Path(name).suffix:
            return name
        return str(OWN / name if (OWN / name).is_file() else data / name)
