"""The page mujoco_robots.md, from the results of its cases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.gap.settings import RankingSettings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

NEAR = 0.25
"""Relative error of a size up to which it counts as right [1]."""
INTERVAL = 1.96
"""Half of a 95 % interval, over the standard deviation [1]."""
FLOORS = RankingSettings().floors
"""Floors with tolerance up to which a log is explained [1]."""
HEAD = """# Arms of MuJoCo

Written by `python docs/results/programs/simulated/mujoco_robots.py`.
Arms of two to four joints, drawn with a seed, one in three without
gravity, and a UR5e from its URDF with six joints are simulated by MuJoCo and hide several effects each. The nominal
model is imported from MJCF or URDF; the logs, {duration:g} s at 250 Hz, are CSV files with a mapping. A first log is
fitted, a second one held out, and the gaps below are those of a third one, which is not used. Torques are commands or,
in half of the cases, measured ones, noted at the begin or the end of the sample in which they act.

- **torque**: friction, inertia of motors, gain of a motor, and a load at the end of the arm that no robot file states.
- **delay**: friction, inertia, and commands or positions that are one to five samples late.
- **elastic**: gears with springs, motor encoders alone, and one spring whose stiffness is wrong by 25 to 60 %.
- **backlash**: the same gears, one of them with a gap of 3 to 20 mrad.
- **servo**: position actuators, and a log without torques: gains, friction, inertia, delay.
- **many**: thirty effects at once on the UR5e: friction, a constant torque and a rotor at every joint, gains at four of
  them, a load and a delay. Two cases, added later: each states the commit that ran it in mujoco_robots.json.

Below, an effect is *shown* by the log if a model with all other true effects leaves a gap: more than noise and the
tolerances of a measured log (5 % of the torques, 3 % of the nominal numbers), and more than two floors. Others cannot
be found without claims that the log does not support. *False* are named effects that are not hidden. A size is right
within 25 %, and in its interval within 1.96 of its stated standard deviations. The arms, effects and motions of these
cases were drawn once and not used before, and run once, by commit a5cec84f beside other work on the same two cores.
`explained` says that at most two floors with tolerance are left on held-out data. Below is counted where the third log
has more than the plain floor then (noise, and tolerances of the torques as white noise), and where it has more than
those two.

"""
MISSED = """
## What is wrong, and why

- Beside a load that multiplies the torque of the last motor by three, and a torque constant that is 19 % too low at the
  other, an inertia of 58 % less is named, and the load is 17 % too heavy (torque:7603): the regression that estimates
  the load knows no wrong torque constants. Of the third log 35 floors are left, less than the two floors with
  tolerance up to which a log counts as explained.
- A diagnosis ended in an internal error (backlash:7634): SciPy could not sort the eigenvalues of a Riccati equation of
  the proposed experiment. Mended; this case and those after it were run by commit 7a95b082.
- Thirty effects (many, run by commit 83cc229a): wrists weigh little, so that no gravity fixes the common scale of gain,
  rotor and friction there. Two or three gains are missing, all sizes at their motors are off by the same factor, which
  their intervals do not say, and a load or false names beside them make up for it (many:7662). Both searches ended at
  the limit of 150 s.
- Else all sizes outside their intervals but a rotor inertia are delays, which are found about 0.1 ms too short: half a
  step of MuJoCo here.

The 28 cases before (seeds 7501 to 7552, commit 5d26139b) had 105 of 106 shown effects named, 4 false ones, 99 of 105
sizes in their intervals and no log refused. Three of the false ones and the missing effect were of one arm, for whose
load of 0.3 kg a payload, inertias and a gain stood; such loads are tried in a fit since then (`with_load`). The 28
before these (seeds 7401 to 7452) had 110 of 112 with 2 false ones and a correct log refused.
"""


def page(found: Mapping[str, Mapping[str, Any]], duration: float) -> str:
    """Write the page.

    Args:
        found: Result by case.
        duration: Duration of a log [s].
    """
    text = HEAD.format(duration=duration)
    text += "| mode | cases | effects shown | named | of all hidden | sizes right | in their 95 % intervals | false | "
    text += "explained, partly, ambiguous, other | `explained` above the floor, above two with tolerance | "
    text += "closed, median | time, median |\n"
    text += "|" + "---|" * 12 + "\n"
    for mode in dict.fromkeys(name.partition(":")[0] for name in found):
        text += _summary(mode, [one for name, one in found.items() if name.partition(":")[0] == mode])
    text += _summary("all", list(found.values()))
    text += "\n| case | robot | shown: hidden size, named size ± its deviation (*outside the interval*) | not shown | "
    text += "false | verdict | gap before | after | time |\n|" + "---|" * 9 + "\n"
    return text + "".join(_row(name, one) for name, one in found.items()) + MISSED


def _shown(one: Mapping[str, Any]) -> list[str]:
    return [name for name, shown in one["visible"].items() if shown]


def _false(one: Mapping[str, Any]) -> list[str]:
    return [name for name in one["named"] if name not in one["hidden"]]


def _right(one: Mapping[str, Any], name: str) -> bool:
    size = one["hidden"][name]
    return name in one["named"] and abs(one["named"][name] - size) <= NEAR * abs(size)


def _in_interval(one: Mapping[str, Any], name: str) -> bool:
    return name in one["named"] and abs(one["named"][name] - one["hidden"][name]) <= INTERVAL * one["deviations"][name]


def _summary(mode: str, cases: Sequence[Mapping[str, Any]]) -> str:
    done = [one for one in cases if "refused" not in one]
    shown = [(one, name) for one in done for name in _shown(one)]
    named = sum(name in one["named"] for one, name in shown)
    right = sum(_right(one, name) for one, name in shown)
    hidden = [(one, name) for one in done for name in one["hidden"]]
    of_hidden = sum(name in one["named"] for one, name in hidden)
    within = sum(_in_interval(one, name) for one, name in shown)
    false = sum(len(_false(one)) for one in done)
    verdicts = [one["verdict"] for one in done]
    counts = [verdicts.count(kind) for kind in ("explained", "partly_explained", "ambiguous")]
    explained = [one["gap"] for one in done if one["verdict"] == "explained"]
    above = sum((gap["after"] or 0.0) > gap["noise_floor"] for gap in explained)
    far = sum((gap["after"] or 0.0) > FLOORS * (gap["tolerance_floor"] or gap["noise_floor"]) for gap in explained)
    closed = [one["gap"]["closed_fraction"] or 0.0 for one in done if one["gap"]["before"] > one["gap"]["noise_floor"]]
    median = 100 * float(np.median(closed)) if closed else 0.0
    return (
        f"| {mode} | {len(cases)} | {len(shown)} | {named} | {of_hidden} of {len(hidden)} | {right} | "
        f"{within} of {named} | {false} | "
        f"{', '.join(map(str, counts))}, {len(cases) - sum(counts)} | {above}, {far} | "
        f"{median:.1f} % | {np.median([one['seconds'] for one in done]):.0f} s |\n"
    )


def _row(name: str, one: Mapping[str, Any]) -> str:
    if "refused" in one:
        return f"| {name} | {one['robot']} | refused: {one['refused']} | | | | | | |\n"
    shown = [f"{each} {one['hidden'][each]:.3g}, {_size(one, each)}" for each in _shown(one)]
    hidden = [f"{each} {size:.3g}" for each, size in one["hidden"].items() if not one["visible"][each]]
    false = [f"{each} {one['named'][each]:.3g}" for each in _false(one)]
    after = "-" if one["gap"]["after"] is None else f"{one['gap']['after']:.3g}"
    return (
        f"| {name} | {one['robot']}, {one['motors']} motors | {'; '.join(shown) or '-'} | {'; '.join(hidden) or '-'} | "
        f"{'; '.join(false) or '-'} | {one['verdict']}{', partial' if one['partial'] else ''} | "
        f"{one['gap']['before']:.3g} | {after} | {one['seconds']:.0f} s |\n"
    )


def _size(one: Mapping[str, Any], name: str) -> str:
    if name not in one["named"]:
        return "**missed**"
    text = f"{one['named'][name]:.3g} ± {one['deviations'][name]:.2g}"
    return text if _in_interval(one, name) else f"*{text}*"
