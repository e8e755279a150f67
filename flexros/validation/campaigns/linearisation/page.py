"""Page of results of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.report.number_text import number
from flexros.validation.campaigns.linearisation.conclusions import QUASI, STATES, STATIC, answer, duels
from flexros.validation.campaigns.linearisation.conditions import CONDITIONS, EXACT
from flexros.validation.campaigns.linearisation.pictures import pictures
from flexros.validation.campaigns.linearisation.robots import CALM, CHIRP, END, SECOND
from flexros.validation.campaigns.linearisation.settings import TUNINGS
from flexros.validation.campaigns.linearisation.tuning import DELAY, SENSITIVITY
from flexros.validation.campaigns.markdown import version_line

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.validation.campaigns.linearisation.figures import Figure, Results

_FIGURES = {
    "track": "Largest tool error of the motion [mm]",
    "push": "Largest deflection after the step of the force at the tool [mm]",
    "hold": f"Deflection that the force leaves after {SECOND - CALM:g} s [mm]",
    "motor": "Largest deflection after the step of the torque at motor 1 [mm]",
    "shake": "Largest deflection under the chirp of the force [mm]",
    "noise": "Change of the torque from sample to sample at rest, rms [Nm]",
}
_DISTURBED = (
    "exact model: none",
    "model error: 15 %",
    "delay: 4 ms",
    "sample time: 4 ms",
    "everything together: harsh",
)


def page(results: Results, used: Mapping[str, str]) -> str:
    """Write the page.

    Args:
        results: All runs.
        used: Versions by package.

    Returns:
        Markdown.
    """
    lines = [
        *_introduction(results),
        "## The answer",
        "",
        *(f"- {sentence}" for sentence in answer(results)),
        "",
        *_pictures(results),
        *_why(),
        *_tuning(results),
    ]
    for robot in results.settings.robots:
        for tuning in results.settings.tunings:
            lines += _tables(results, robot.name, tuning)
    lines += [*_duels(results), *_limits(), f"{version_line(used)}."]
    return "\n".join(lines) + "\n"


def _introduction(results: Results) -> list[str]:
    settings = results.settings
    return [
        "# Feedback linearisation or feedforward?",
        "",
        "Written by `flexros campaign linearisation` from its runs. Moberg (2007) leaves open whether the nonlinear "
        "model "
        "belongs into the feedback loop or into the feedforward (section 5.6), and asks for a comparative study with "
        "regard to robustness, in tracking and in disturbance rejection (section 6.2). This is one, in simulation.",
        "",
        f"Every law knows the nominal robot; the plant differs from it. A random model error is drawn {settings.draws} "
        f"times, the same plants for every law; other conditions are run with {settings.repetitions} seeds of the "
        f"noise "
        f"(seed {settings.seed} and following). Figures are medians; brackets hold the 95 % interval of the median "
        f"from "
        "order statistics. A run that diverges or moves the tool 50 mm from its place is lost and counts as infinite. "
        "The "
        "true tool is judged, not a tracker's.",
        "",
    ]


def _pictures(results: Results) -> list[str]:
    lines = []
    for name in pictures(results):
        what = (
            "Largest tool error of the motion" if name.startswith("tracking") else "Largest deflection after the force"
        )
        robot = name.partition("_")[2]
        text = f"{what} [mm], {robot}, equal robustness, over the size of one deviation at a time"
        lines += [
            f"![{text}](figures/linearisation_{name}.svg)",
            "",
            f"*{text}. A line that leaves the panel: runs are lost.*",
            "",
        ]
    return lines


def _why() -> list[str]:
    return [
        "## Why",
        "",
        "- *The model acts on what is measured, or on what is wanted.* Equation 5.12 evaluates the model on the "
        "reference, "
        "which is exact, early and free of noise: errors of the model are a disturbance of limited size that any "
        "feedback "
        "may then reduce. Equation 5.11 evaluates it on measured states, so the same errors change the loop itself.",
        "- *Static linearisation takes acceleration and jerk of the links from the model.* Under a load e = J^T F "
        "that the "
        "model does not have, the torques of the gears hold the load at rest, but the law reads a = M^-1 e from them, "
        "and "
        "rests where q_r - q = (6 / w^2 - M^-1 K / w^4) a. No bandwidth that the margins allow makes that small. "
        "Quasi-static linearisation takes both from the wanted motion and does not have this term.",
        "- *Poles far below the resonance cost robustness.* The laws that place all poles of a link need "
        "sensitivities far "
        "above 2 at low bandwidths, where the PD controllers are most robust: they push a resonance that the "
        "robot keeps by itself to where the designer wants it (table of sensitivities below).",
        "- *Delay acts on all that passes through the loop.* In feedforward nothing but the correction is late; the "
        "motion "
        "as a whole comes later by the delay of the command, which preview would remove.",
        "- *Two errors may cancel.* What quasi-static linearisation neglects of the dampers acts against a delay: its "
        "error "
        "falls with the first milliseconds before it rises.",
        "- *Estimated states are those of a model.* With motor encoders alone the Kalman filter predicts the links "
        "with the "
        "nominal model, whose errors then enter either law through the estimate.",
        "- *Dampers of the gears.* The linearising laws are exact without them (5.4); the DAE contains them. See the "
        "row "
        "of gears without dampers, where the laws of feedforward have the wrong model.",
        "",
    ]


def _tuning(results: Results) -> list[str]:
    robots = {robot.name: robot for robot in results.settings.robots}
    lines = [
        "## How the laws are tuned",
        "",
        "No law has integral action except the PID. Each has a bandwidth and at most one more number. *Equal "
        "robustness*: "
        f"of all pairs of a grid, the one of the smallest rms of the tool under white forces and torques, among those "
        f"whose sensitivity at every motor is at most {SENSITIVITY:g} in three poses, with {1e3 * DELAY:g} ms of "
        f"delay, "
        "and whose torque noise from the encoders is at most "
        + " and ".join(f"{robot.torque_noise:g} Nm ({name})" for name, robot in robots.items())
        + ". *Equal bandwidth*: "
        + " and ".join(f"{robot.bandwidth:g} rad/s ({name})" for name, robot in robots.items())
        + ", the second number as usual (damping ratio 1). Loops are sampled at 2 kHz and linear about rest. Gains "
        "stay "
        "as they are under all conditions. Link encoders are as good as those of the motors (2e-6 rad).",
        "",
        "| robot | tuning | law | w [rad/s] | second | sensitivity | compliance [um] | torque noise [Nm] | gain margin "
        "| delay margin [ms] |",
        "|---" * 10 + "|",
    ]
    texts = {}
    for robot in robots:
        for tuning in results.settings.tunings:
            for law in results.laws(robot, tuning):
                texts[law.name] = law.text
                found = results.parts[robot, tuning, law.name]["tuning"]
                delay = found["delay_margin"]
                cells = [found["bandwidth"], found["second"], found["sensitivity"], found["compliance"]]
                cells += [found["torque_noise"], found["gain_margin"], None if delay is None else 1e3 * delay]
                shown = " | ".join("unstable" if cell is None else number(cell, 3) for cell in cells)
                lines.append(f"| {robot} | {tuning} | {law.name} | {shown} |")
    lines += ["", *(f"- {name}: {text}." for name, text in texts.items()), ""]
    return [*lines, *_robustness(results)]


def _robustness(results: Results) -> list[str]:
    """Return the sensitivity of every law over its bandwidth."""
    lines = []
    for robot, part in results.robustness.items():
        bandwidths = [f"{w:g}" for w in part["bandwidths"]]
        lines += [
            f"Largest sensitivity on {robot} over the bandwidth [rad/s], the second number as in the tuning of equal "
            "bandwidth:",
            "",
            f"| law | {' | '.join(bandwidths)} |",
            "|---" * (len(bandwidths) + 1) + "|",
        ]
        for law, values in part["sensitivity"].items():
            cells = " | ".join("unstable" if value is None else number(value, 3) for value in values)
            lines.append(f"| {law} | {cells} |")
        lines.append("")
    return lines


def _tables(results: Results, robot: str, tuning: str) -> list[str]:
    laws = results.laws(robot, tuning)
    if not laws:
        return []
    lines = [f"## {robot}, {tuning}", ""]
    for key, title in _FIGURES.items():
        chosen = [each for each in results.settings.conditions if key == "track" or each.name in _DISTURBED]
        if key == "noise":
            chosen = [each for each in chosen if each.name == EXACT.name]
        if not chosen:
            continue
        lines += [f"**{title}**", "", "| condition | " + " | ".join(law.short for law in laws) + " |"]
        lines.append("|---" * (len(laws) + 1) + "|")
        for condition in chosen:
            figures = [results.figure(robot, tuning, law.name, condition.name, key) for law in laws]
            least = min(figure.median for figure in figures)
            cells = " | ".join(_cell(figure, bold=figure.median == least and np.isfinite(least)) for figure in figures)
            lines.append(f"| {condition.name} | {cells} |")
        lines.append("")
    if tuning == TUNINGS[0]:
        one = results.settings.robots[[each.name for each in results.settings.robots].index(robot)]
        lines += [
            f"Disturbances: {one.force:g} N along z at the tool from {CALM:g} s on, {one.torque:g} Nm at motor 1 from "
            f"{SECOND:g} s on, a chirp of {one.chirp:g} N from {CHIRP:g} to {END:g} s; each counts from where the tool "
            "was before it.",
            "",
        ]
    return lines


def _duels(results: Results) -> list[str]:
    """Return the comparison of linearisation and feedforward run by run, for both tunings."""
    lines = []
    for tuning in results.settings.tunings:
        names = {law.name for law in results.laws("elbow", tuning)}
        if not {STATES, STATIC, QUASI} <= names:
            continue
        lines += [
            f"## The same plants, run by run: elbow, {tuning}",
            "",
            f"Tracking error of the linearising law over that of {STATES}: median and 95 % interval of the median; "
            f"runs "
            "in which the linearising law is better.",
            "",
            "| condition | static / feedforward | better | quasi-static / feedforward | better |",
            "|---" * 5 + "|",
        ]
        static, quasi = (duels(results, law, STATES, "track", tuning) for law in (STATIC, QUASI))
        for name in static:
            cells = []
            for found in (static[name], quasi[name]):
                cells += [_interval(found.ratio, found.low, found.high), f"{found.better} of {found.runs}"]
            lines.append(f"| {name} | {' | '.join(cells)} |")
        lines.append("")
    return lines


def _limits() -> list[str]:
    largest = max(each.sample_time for each in CONDITIONS)
    return [
        "## What this does not show",
        "",
        "- One motion on each robot, and one pose of disturbances; random errors are independent and uniform.",
        "- Static linearisation has all four poles of a link at one place; another matrix L of equation 5.10 would "
        "move the "
        "ratio of its gains, not the term that reads loads as accelerations.",
        "- State feedback is diagonal, with LQ gains of single axes; a design of all axes together would be better, in "
        "particular on e12, whose axes are strongly coupled.",
        "- *Feedforward + states, estimated* ends at the edge of the grid of its two numbers on the elbow: a better "
        "design "
        "may exist. On e12 the references of the links are those of the rigid arm and not of the DAE, which costs "
        "*feedforward + states* 1 to 2 mm with the exact model.",
        f"- Gains are not designed again for longer sample times (up to {1e3 * largest:g} ms) or more noise.",
        "- Neither integral action nor a disturbance observer in the linearising laws; the author expects that "
        "industry "
        "needs one. The PID shows what it gives to the simplest law.",
        "",
    ]


def _cell(figure: Figure, *, bold: bool) -> str:
    if not np.isfinite(figure.median):
        return f"lost ({figure.lost} of {figure.runs})"
    text = f"**{number(figure.median, 3)}**" if bold else number(figure.median, 3)
    same = figure.high - figure.low < 0.02 * figure.median
    text += "" if same else f" ({_end(figure.low)} to {_end(figure.high)})"
    return text + (f", {figure.lost} lost" if figure.lost else "")


def _interval(median: float, low: float, high: float) -> str:
    return f"{_end(median)} ({_end(low)} to {_end(high)})"


def _end(value: float) -> str:
    return number(value, 3) if np.isfinite(value) else "lost"
