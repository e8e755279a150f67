"""The answer of the study in sentences, each computed from the runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.campaigns.linearisation.conditions import EXACT
from flexros.validation.campaigns.linearisation.figures import duel
from flexros.validation.campaigns.linearisation.robots import CALM, SECOND, Encoders, robot_with
from flexros.validation.campaigns.linearisation.sag import sag_of_static_linearisation
from flexros.validation.campaigns.linearisation.settings import TUNINGS

if TYPE_CHECKING:
    from flexros.validation.campaigns.linearisation.figures import Duel, Results

STATES, STATIC, QUASI = "feedforward + states", "static linearisation", "quasi-static linearisation"
PD, PID, RIGID, TORQUE = "PD + DAE feedforward", "PID + DAE feedforward", "PD + rigid feedforward", "computed torque"
STATIC_ESTIMATED, STATES_ESTIMATED = "static linearisation, estimated", "feedforward + states, estimated"
ELBOW = "elbow"


def answer(results: Results) -> tuple[str, ...]:
    """Answer the question of the thesis' author, one sentence or two for each aspect.

    Args:
        results: All runs; sentences of laws, robots or conditions that were not run are left out.
    """
    fit = {law.name for law in results.laws(ELBOW, TUNINGS[0])} if TUNINGS[0] in results.settings.tunings else set()
    if not {STATES, STATIC, QUASI, PD} <= fit:
        return ("The laws that are to be compared were not all run.",)
    aspects = (
        _lead,
        _verdict,
        _where_it_wins,
        _exact,
        _errors,
        _timing,
        _noise,
        _disturbances,
        _sag,
        _motors_only,
        _rigid_in_the_loop,
    )
    return tuple(sentence for aspect in aspects for sentence in aspect(results)) + _structure(results)


def duels(results: Results, first: str, second: str, key: str, tuning: str = TUNINGS[0]) -> dict[str, Duel]:
    """Compare two laws on the elbow under every condition."""
    return {
        condition.name: duel(
            results.values(ELBOW, tuning, first, condition.name, key),
            results.values(ELBOW, tuning, second, condition.name, key),
        )
        for condition in results.settings.conditions
    }


def _lead(results: Results) -> list[str]:
    """Say where the model belongs: clear if the better side wins twice as often against both rivals."""
    counts = []
    for law in (STATIC, QUASI):
        found = duels(results, law, STATES, "track").values()
        counts.append((sum(each.low > 1.0 for each in found), sum(each.high < 1.0 for each in found)))
    if all(wins > 2 * losses for wins, losses in counts):
        place = "**In the feedforward.** The nonlinear model serves better there than in the feedback loop"
    elif all(losses > 2 * wins for wins, losses in counts):
        place = "**In the feedback loop.** The nonlinear model serves better there than in the feedforward"
    else:
        place = "**Neither clearly.** Whether the loop or the feedforward is the better place depends on the condition"
    held = {
        name: results.figure(ELBOW, TUNINGS[0], name, EXACT.name, "push").median for name in (STATES, STATIC, QUASI)
    }
    least = min(held, key=lambda name: held[name])
    return [
        f"{place}, for tracking; under a force at the tool the stiffest of the three is {least} ({held[least]:.3g} mm)."
    ]


def _verdict(results: Results) -> list[str]:
    lines = []
    for law in (STATIC, QUASI):
        found = duels(results, law, STATES, "track")
        wins, losses = (
            sum(side) for side in ([d.low > 1.0 for d in found.values()], [d.high < 1.0 for d in found.values()])
        )
        lines.append(
            f"With the same encoders and equal robustness, feedforward with state feedback (5.12) tracks better than "
            f"{law} under {wins} of {len(found)} conditions, and worse under {losses} (95 % intervals of the median "
            f"ratio of the largest errors; median over the conditions {_middle(found):.2f})."
        )
    return lines


def _where_it_wins(results: Results) -> list[str]:
    """Name the conditions under which a linearising law tracks better, with either tuning."""
    lines = []
    for tuning in results.settings.tunings:
        for law in (STATIC, QUASI):
            names = [name for name, found in duels(results, law, STATES, "track", tuning).items() if found.high < 1.0]
            if names:
                lines.append(f"With {tuning}, {law} tracks better than 5.12 under: {', '.join(names)}.")
    return lines


def _exact(results: Results) -> list[str]:
    names = (STATES, PD, QUASI, STATIC, TORQUE, RIGID)
    listed = ", ".join(f"{name} {_mm(results, name, EXACT.name)}" for name in names if _ran(results, name))
    return [f"With the exact model, all differ only by what they leave out (largest tool error, mm): {listed}."]


def _errors(results: Results) -> list[str]:
    lines = []
    for condition in ("model error: 15 %", "payload: +20 %", "Coulomb friction: 3 % of the torque"):
        if condition in _conditions(results):
            listed = ", ".join(
                f"{name} {_mm(results, name, condition)}"
                for name in (STATES, PD, PID, QUASI, STATIC, TORQUE)
                if _ran(results, name)
            )
            best = results.best(ELBOW, TUNINGS[0], condition, "track")
            lines.append(f"{condition[0].upper()}{condition[1:]}: {listed}; best is {best}.")
    return lines


def _timing(results: Results) -> list[str]:
    lines = []
    for condition in ("delay: 2 ms", "delay: 4 ms", "sample time: 4 ms"):
        if condition in _conditions(results):
            listed = ", ".join(
                f"{name} {_mm(results, name, condition)} ({_share(results, name, condition)})"
                for name in (STATES, PD, QUASI, STATIC)
            )
            lines.append(f"{condition[0].upper()}{condition[1:]} (in brackets: of runs lost): {listed}.")
    return lines


def _noise(results: Results) -> list[str]:
    listed = ", ".join(
        f"{name} {results.figure(ELBOW, TUNINGS[0], name, EXACT.name, 'noise').median:.3g}"
        for name in (STATES, PD, QUASI, STATIC, STATIC_ESTIMATED, STATES_ESTIMATED)
        if _ran(results, name)
    )
    return [f"Noise of the encoders in the torque (rms of the change between samples, Nm): {listed}."]


def _disturbances(results: Results) -> list[str]:
    lines = []
    for key, text in (
        ("push", "Largest deflection after a step of the force at the tool"),
        ("hold", f"What remains of it after {SECOND - CALM:g} s"),
        ("motor", "Largest deflection after a step of the torque at motor 1"),
        ("shake", "Largest deflection while the force sweeps 1 to 30 Hz"),
    ):
        listed = ", ".join(
            f"{name} {results.figure(ELBOW, TUNINGS[0], name, EXACT.name, key).median:.3g}"
            for name in (STATES, PD, PID, QUASI, STATIC, TORQUE)
            if _ran(results, name)
        )
        best = results.best(ELBOW, TUNINGS[0], EXACT.name, key)
        lines.append(f"{text} (mm): {listed}; best is {best}.")
    return lines


def _sag(results: Results) -> list[str]:
    robot = next(each for each in results.settings.robots if each.name == ELBOW)
    w = results.parts[ELBOW, TUNINGS[0], STATIC]["tuning"]["bandwidth"]
    wanted = sag_of_static_linearisation(robot_with(ELBOW, Encoders(links=True)), robot.poses[0], robot.force, w)
    found = results.figure(ELBOW, TUNINGS[0], STATIC, EXACT.name, "hold").median
    return [
        f"Why static linearisation yields to loads: it computes the acceleration of the links from the torques of the "
        f"gears, so a load that the model does not have reads as an acceleration, and the law gives way to it. The "
        f"formula (below) predicts {wanted:.3g} mm for the force at the tool; simulated are {found:.3g} mm. Gravity, "
        "inertia and payload that are wrong in the model act as such a load."
    ]


def _motors_only(results: Results) -> list[str]:
    if not (_ran(results, STATIC_ESTIMATED) and _ran(results, STATES_ESTIMATED)):
        return []
    parts = []
    for name, full in ((STATIC_ESTIMATED, STATIC), (STATES_ESTIMATED, STATES)):
        tuning = results.parts[ELBOW, TUNINGS[0], name]["tuning"]
        parts.append(
            f"{name} {_mm(results, name, 'model error: 15 %')} instead of {_mm(results, full, 'model error: 15 %')} "
            f"(sensitivity {tuning['sensitivity']:.3g})"
        )
    if "model error: 15 %" not in _conditions(results):
        return []
    simple = _mm(results, PD, "model error: 15 %")
    return [
        "From motor encoders alone, with a Kalman filter, largest error at a model error of 15 % (mm): "
        f"{'; '.join(parts)}. The PD controller with DAE feedforward needs no estimate: {simple}."
    ]


def _rigid_in_the_loop(results: Results) -> list[str]:
    if not (_ran(results, TORQUE) and _ran(results, PD)):
        return []
    found = duels(results, TORQUE, PD, "track")
    wins = sum(d.low > 1.0 for d in found.values())
    losses = sum(d.high < 1.0 for d in found.values())
    return [
        f"Computed torque, the rigid model in the loop, tracks worse than a PD controller with DAE feedforward under "
        f"{wins} of {len(found)} conditions and better under {losses}: both need motor encoders alone."
    ]


def _structure(results: Results) -> tuple[str, ...]:
    lines = []
    for robot in results.settings.robots:
        refused = results.refusals(robot.name)
        if refused:
            reason = next(iter(refused.values()))
            lines.append(
                f"On {robot.name} {len(refused)} of {len(results.settings.laws)} laws do not exist at all "
                f"({', '.join(refused)}): {reason.split('; choose')[0]}. Feedforward from the DAE does not need that."
            )
    return tuple(lines)


def _conditions(results: Results) -> set[str]:
    return {condition.name for condition in results.settings.conditions}


def _ran(results: Results, law: str) -> bool:
    return "runs" in results.parts.get((ELBOW, TUNINGS[0], law), {})


def _mm(results: Results, law: str, condition: str) -> str:
    median = results.figure(ELBOW, TUNINGS[0], law, condition, "track").median
    return f"{median:.3g}" if np.isfinite(median) else "lost"


def _share(results: Results, law: str, condition: str) -> str:
    figure = results.figure(ELBOW, TUNINGS[0], law, condition, "track")
    return f"{figure.lost} of {figure.runs}"


def _middle(found: dict[str, Duel]) -> float:
    return float(np.median([each.ratio for each in found.values()]))
