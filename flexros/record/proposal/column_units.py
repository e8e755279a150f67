"""Units in the names of columns, as `Angle (rad)`, `tau [Nm]` and `speed_rad_per_s`."""

from __future__ import annotations

import re
from dataclasses import dataclass

from flexros.logs.foreign.quantities import UNITS

_BRACKETS = re.compile(r"[\[(](?P<unit>[^\[\]()]*)[\])]\s*$")
_WORDS = re.compile(r"[A-Za-z]+|\d+")
_SPELLED = {
    "rad": "rad radian radians", "mrad": "mrad", "deg": "deg degs degree degrees", "turn": "turn turns rev revs",
    "rad/s": "rad_s", "deg/s": "deg_s degree_s degrees_s", "rpm": "rpm rev_min", "turn/s": "turn_s turns_s rev_s rps",
    "Nm": "nm n_m", "mNm": "mnm", "kNm": "knm",
}  # fmt: skip
_OF_SLIDES = {"m": "m", "mm": "mm", "um": "um", "m/s": "m_s", "mm/s": "mm_s", "N": "n", "kN": "kn"}
"""Only in brackets: these are words of other meanings too."""
_OTHERS = {"", "unit", "units", "a", "amp", "amps", "ma", "v", "count", "counts", "ticks", "s", "ms", "us", "ns"}
"""Units in brackets that say nothing about positions, velocities and torques."""


def _by_spelling(*tables: dict[str, str]) -> dict[str, str]:
    return {spelled: unit for table in tables for unit, words in table.items() for spelled in words.split()}


_BEHIND, _IN_BRACKETS = _by_spelling(_SPELLED), _by_spelling(_SPELLED, _OF_SLIDES)
_LONGEST = 3
"""Most words of a unit behind a name, as rad per s."""
_NUMBER = re.compile(r"[\W_]+\d+[\W_]*$")
"""Number of a joint behind a unit, as in q_rad_1."""


@dataclass(frozen=True)
class _UnitWords:
    """Words of a unit in a name.

    Attributes:
        begin: Where they begin.
        end: Where they end.
        unit: The unit.
    """

    begin: int
    end: int
    unit: str


def name_without_unit(name: str) -> str:
    """Return the name of a column without its unit: in brackets at the end, or in words there or before a number."""
    found = _BRACKETS.search(name)
    if found and (_spelling(found["unit"]) in _IN_BRACKETS.keys() | _OTHERS):
        return name[: found.start()]
    words = _in_words(name)
    return name if words is None else name[: words.begin] + name[words.end :]


def unit_in_name(name: str, kind: str) -> str | None:
    """Return the unit that the name of a column states; None for none, or one of another kind.

    Args:
        name: Name of the column.
        kind: Kind of its quantity: "position", "velocity" or "torque".
    """
    found, words = _BRACKETS.search(name), _in_words(name)
    unit = _IN_BRACKETS.get(_spelling(found["unit"])) if found else None
    unit = unit or (words.unit if words else None)
    return unit if unit and UNITS[unit].kind == kind else None


def _spelling(unit: str) -> str:
    """Return the words of a unit in one way of writing, as rad_s of rad/sec."""
    words = [word.lower() for word in _WORDS.findall(unit.replace("°", "deg"))]
    same = {"sec": "s", "secs": "s", "second": "s", "seconds": "s", "minute": "min"}
    return "_".join(same.get(word, word) for word in words if word != "per")


def _in_words(name: str) -> _UnitWords | None:
    """Return the words of a unit behind a name; None where there are none."""
    number = _NUMBER.search(name)
    end = number.start() if number else len(name)
    words = list(_WORDS.finditer(name, 0, end))
    for count in range(min(_LONGEST, len(words) - 1), 0, -1):
        begin = words[-count].start()
        unit = _BEHIND.get(_spelling(name[begin:end]))
        if unit is not None and not name[begin - 1].isalnum():
            return _UnitWords(begin, end, unit)
    return None
