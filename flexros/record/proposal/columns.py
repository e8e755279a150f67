"""Which columns of a table hold which quantity, by the words of their names: time, q1, dq1, tau1, elbow_position."""

from __future__ import annotations

import re
from collections import defaultdict
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError
from flexros.logs.foreign.mapping import Clock
from flexros.logs.foreign.quantities import TIME_UNITS
from flexros.record.proposal.column_units import name_without_unit
from flexros.record.proposal.found_signals import FoundSignals

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from flexros.arrays import FloatArray

_TOKEN = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_KINDS = {
    "position": "q qpos jpos pos position positions ang angle angles theta th",
    "velocity": "dq qd qdot qvel jvel vel velocity velocities speed speeds omega",
    "torque": "tau jtau torque torques torq tor trq effort efforts eff moment force forces frc u",
    "acceleration": "ddq qdd qddot acc accel acceleration accelerations",
    "current": "current currents cur i",
}
_KIND = {word: kind for kind, words in _KINDS.items() for word in words.split()}
_WANTED = {"ref", "reference", "des", "desired", "target", "setpoint", "d"} | {
    "cmd", "command", "commands", "commanded", "goal", "demand", "demanded", "action"
}  # fmt: skip
_TIMES = {"t", "time", "timestamp", "timestamps", "stamp", "clock"}
_STAMPS, _DURATIONS = _TIMES - {"t", "clock"}, {"loop", "cycle", "sample", "step", "delta", "period", "compute"}
"""Words that make any name one of times, as pi_time, and those beside which it is that of durations."""
_SECONDS = {"s": "s", "sec": "s", "secs": "s", "seconds": "s"} | {unit: unit for unit in TIME_UNITS}
_FILLING = {
    "joint", "joints", "j", "motor", "m", "axis", "state", "states", "raw", "filtered", "filt",
    "unfiltered", "est", "estimated", "measurement", "value", "rad", "deg", "nm", "in", "of", "the",
}  # fmt: skip
"""Words of a name that say neither quantity nor joint."""
_MEASURED = {"actual", "act", "measured", "meas", "present", "feedback", "fb", "fbk", "observation"}
"""Words of no joint, which make a name that of a position where no other one is, and the same joint has a command."""
_STATES = {"enable", "enabled", "limit", "limits", "error", "errors", "err", "mode", "status", "flag"}
"""Words of a name that make its column no signal of the quantity: torque_enable, current_limit, position_error."""
_ELSEWHERE = dict.fromkeys(("ee", "eef", "tcp", "flange", "cartesian", "pose"), "of the tool") | dict.fromkeys(
    ("imu", "gyro", "gyroscope", "accelerometer"), "of an inertial sensor"
)
"""Words of a name that make it one of something else than a joint: ee_pos, tcp_speed, imu_vel."""
_MEANING = _KIND.keys() | _WANTED | _MEASURED | _STATES | _ELSEWHERE.keys()
"""Words of a name that say more than its joint."""
TORQUES = ("measured_torque", "torque_command")
"""Quantities that drive the robot by torques."""
_OF_CURRENT = {"measured_current": "measured_torque", "current_command": "torque_command"}
"""What currents are mapped to, where a table has no torques."""
_FASTEST, _SLOWEST = 50_000.0, 2.0
"""Rates between which a log is expected, by which the unit of its times is told [Hz] (chosen)."""


def table_signals(
    names: Sequence[str],
    file: str,
    *,
    timed: bool = True,
    commands: Literal["position", "torque"] = "position",
    joints: Collection[str] = (),
) -> FoundSignals:
    """Find time, states, commands and references among the columns of a table.

    Args:
        names: Names of its columns.
        file: The file, for error messages.
        timed: Whether a column has the times; else the rate is known.
        commands: What commands are whose names say no quantity, as cmd1.
        joints: Names of the joints of the model, whose words mean no quantity, as wrist_angle.

    Raises:
        InputError: No column is a time though one should be, or none a position.
    """
    signals: dict[str, dict[str, str]] = defaultdict(dict)
    ignored, times, unnamed, group = {}, list[str](), dict[str, str](), _group(names)
    perhaps = list[str]()
    all_words = {name: name_words(name_without_unit(name.removeprefix(group))) for name in names}
    for name, words in _with_whole_joints(all_words, joints).items():
        if words and words[0] in _TIMES and set(words) <= _TIMES | set(_SECONDS):
            times.append(name)
            continue
        if _STAMPS & set(words) and not (_DURATIONS | _KIND.keys()) & set(words):
            perhaps.append(name)
        quantity, joint = _meaning(words, commands)
        if quantity and not _KIND.keys() & set(words):
            unnamed.setdefault(joint, name)
        if quantity is None:
            ignored[name] = joint
        elif joint in signals[quantity]:
            ignored[name] = f"{signals[quantity][joint]} is taken"
        else:
            signals[quantity][joint] = name
    if not signals["position"]:
        left = {name: name_words(name.removeprefix(group)) for name in ignored}
        signals["position"] = _measured_positions(_with_whole_joints(left, joints), unnamed)
        ignored = {name: why for name, why in ignored.items() if name not in signals["position"].values()}
    if timed and not times and perhaps:
        times = perhaps[:1]
        ignored.pop(times[0], None)
    lacking = "position" if not signals["position"] else "time" if timed and not times else ""
    if lacking:
        text = (
            f"{file} has no column whose name says that it is a {lacking} (time; q1, position_1, elbow_pos); its "
            f"columns are {', '.join(names)}: "
        )
        if lacking == "time":
            raise InputError(f"{text}give the rows per second, or rename them", "rate")
        raise InputError(f"{text}rename them, or write a mapping file and give it with its files")
    driven, currents = signals.keys() & set(TORQUES), set[str]()
    for current, torque in _OF_CURRENT.items():
        own = signals.pop(current, {})
        if driven:
            ignored |= dict.fromkeys(own.values(), "a current, but torques are there")
        elif own:
            signals[torque] = own
            currents.add(torque)
    if "reference_position" in signals and not signals.keys() & set(TORQUES):
        signals["position_command"] = signals.pop("reference_position")  # nothing else drives the robot
    ordered = {quantity: dict(sorted(own.items(), key=_place)) for quantity, own in signals.items() if own}
    time = times[0] if timed else ""
    return FoundSignals(file, ordered, ignored, True, time, frozenset(currents), unnamed)


def _measured_positions(names: Mapping[str, Sequence[str]], commanded: Collection[str]) -> dict[str, str]:
    """Return columns that are measured where the same joint is commanded, as present_1 beside goal_1, by joint.

    Args:
        names: Words of their names without what all begin with, by column.
        commanded: Joints with commands whose names say no quantity either.
    """
    found: dict[str, str] = {}
    for column, words in names.items():
        quantity, joint = _meaning([*words, "position"], "position")
        if _MEASURED & set(words) and quantity == "position" and joint in commanded:
            found.setdefault(joint, column)
    return found


def name_words(name: str) -> list[str]:
    """Return the words and numbers of a name in lower case, e.g. fr, hip and 2 of FR_hip2."""
    return [token.lower() for token in _TOKEN.findall(name)]


def own_words(name: str) -> list[str]:
    """Return the words of the name of a joint without those that any joint may have: shoulder of shoulder_joint."""
    return [word for word in name_words(name) if word not in _FILLING]


def _with_whole_joints(names: Mapping[str, list[str]], joints: Collection[str]) -> dict[str, list[str]]:
    """Return the words of names, those of a joint together as one word, as wrist_angle, where they may mean a quantity.

    They are a joint where a quantity stands beside them in any of the names, as in wrist_angle_velocity, but not where
    nothing else names it, as in q1.

    Args:
        names: Words of each name.
        joints: Names of the joints of the model.
    """
    whole = dict(names)
    for joint in sorted(map(name_words, joints), key=len, reverse=True):
        if not _MEANING & set(joint) or not any(word.isalpha() for word in {*joint} - _MEANING - _FILLING):
            continue
        joined = {name: _joined(words, joint) for name, words in whole.items()}
        if any("_".join(joint) in words and _KIND.keys() & set(words) for words in joined.values()):
            whole = joined
    return whole


def _joined(words: list[str], joint: list[str]) -> list[str]:
    """Return words with those of a joint as one."""
    for begin in range(len(words) - len(joint) + 1):
        end = begin + len(joint)
        if words[begin:end] == joint:
            return [*words[:begin], "_".join(joint), *words[end:]]
    return words


def _group(names: Sequence[str]) -> str:
    """Return what all names begin with and no joint or quantity is: the list or group of a file, as `entries.`."""
    group = ""
    while names and all("." in name.removeprefix(group) for name in names):
        longer = {name[: name.index(".", len(group)) + 1] for name in names}
        if len(longer) > 1 or (_KIND.keys() | _TIMES) & {*name_words(min(longer)[len(group) :])}:
            break
        group = min(longer)
    return group


def _meaning(words: Sequence[str], commands: str) -> tuple[str | None, str]:
    """Return quantity and joint by the words of a name, or None and why there is none.

    Args:
        words: The words.
        commands: Quantity of a command whose words say none.
    """
    kinds = [_KIND[word] for word in words if word in _KIND]
    kinds = [kind for kind in kinds if kind != "current"] or kinds  # the present one, as in current_position
    kinds = kinds or [_KIND[word] for joint in words for word in joint.split("_") if word in _KIND]  # as in wrist_angle
    if not kinds and _WANTED & set(words) - {"d"}:
        kinds = [commands]  # as in cmd1
    if not kinds:
        return None, "its name says no quantity"
    if states := [word for word in words if word in _STATES]:
        return None, f"a state of the drive or a limit by its word {states[0]}"
    if elsewhere := [word for word in words if word in _ELSEWHERE]:
        return None, f"{_ELSEWHERE[elsewhere[0]]}, by its word {elsewhere[0]}: map it by hand"
    kind, wanted = kinds[0], bool(_WANTED & set(words))
    if kind == "position" and "dot" in words:
        kind = "velocity"
    left = [word for word in words if word not in _WANTED | _MEASURED | _KIND.keys() | {"dot"}]
    own = [word for word in left if word not in _FILLING]
    joint = "_".join(left if not all(word.isdigit() for word in own) else own)
    if kind == "acceleration":
        return None, "not needed"
    if kind == "torque":
        return "torque_command" if wanted or "u" in words else "measured_torque", joint
    if kind == "current":
        return "current_command" if wanted else "measured_current", joint
    return f"reference_{kind}" if wanted else kind, joint


def _place(own: tuple[str, str]) -> tuple[int, ...]:
    """Order numbered joints by their numbers; others stay in the order of the file."""
    return tuple(int(word) for word in own[0].split("_")) if re.fullmatch(r"\d+(_\d+)*", own[0]) else ()


def clock_of_column(name: str, values: FloatArray) -> Clock:
    """Return the clock of a time column, whose unit its name tells, or else the rate.

    Args:
        name: Name of the column.
        values: Its values, shape (n,).
    """
    for word in _TOKEN.findall(name):
        if word.lower() in _SECONDS:
            return Clock(column=name, unit=_SECONDS[word.lower()])
    step = float(np.median(np.diff(values))) if len(values) > 1 else 1.0
    for unit, size in TIME_UNITS.items():
        if step > 0 and _SLOWEST <= 1 / (step * size) <= _FASTEST:
            return Clock(column=name, unit=unit)
    return Clock(column=name)
