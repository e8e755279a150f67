"""What the help says of each command beside its options: job, one line, examples; and what to do after it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

ROBOTS, RUNS, LOGS = "Robots and models", "Run and emulate", "Logs and analysis"
IDENTIFY, DIAGNOSE, CONTROL = "Identify", "Diagnose the gap", "Controllers"
HERE, PROOF, OTHER = "This installation", "Proof of our own claims", "Other"
JOBS = (RUNS, LOGS, DIAGNOSE, IDENTIFY, CONTROL, ROBOTS, HERE, PROOF, OTHER)
"""Groups of commands in the help, in order."""


@dataclass(frozen=True)
class Guide:
    """What is said of a command.

    Attributes:
        job: Its group, one of `JOBS`.
        short: One line of the list of commands.
        examples: Command lines, each with what it does after two blanks and a #.
        then: Gives the command that usually comes next from the arguments and the exit code; None where the command
            says it itself, because it depends on the result.
    """

    job: str
    short: str
    examples: tuple[str, ...]
    then: Callable[[Mapping[str, Any], int], str] | None = None


def word(value: object) -> str:
    """Return a value as one word of a command line."""
    return shlex.quote(str(value))


def always(text: str) -> Callable[[Mapping[str, Any], int], str]:
    """Return a next step that is the same for all arguments."""
    return lambda _given, _code: text


def _after_robot(given: Mapping[str, Any], _: int) -> str:
    return (
        f"flexros run diagnosis --model {word(given['name'])} --out log    a run of it; or flexros design lqg --model"
    )


def _after_analyze(given: Mapping[str, Any], _: int) -> str:
    bag = word(given["bag"][0])
    if given["report"]:
        return f"flexros gap {bag} --model ROBOT    how far robot and model are apart"
    return f"flexros analyze {bag} --report report.html    the same with pictures"


def _after_compare(given: Mapping[str, Any], _: int) -> str:
    folders = [word(folder) for folder in given["diagnosis"]]
    if not given["report"]:
        return f"flexros compare {' '.join(folders)} --report compared.html    the same with pictures"
    return f"flexros view {folders[0]}    the robot, its nominal and its repaired model in motion"


def _after_monitor(given: Mapping[str, Any], code: int) -> str:
    bag, model = word(given["bag"]), word(given["model"])
    if given["calibrate"]:
        return f"flexros monitor ANOTHER_LOG --model {model} --thresholds {word(given['calibrate'])}"
    if code:
        return f"flexros diagnose {bag} --model {model} --out diagnosis    which effect causes the alarm"
    return "docs/how-to/gap_monitor.md    the same beside a running robot"


def _after_design(given: Mapping[str, Any], _: int) -> str:
    if not given["method"]:
        return "flexros design lqg --model four_mass --out lqg.yaml    design one"
    if given["out"]:
        return f"flexros benchmark {word(given['out'])} --report benchmark.html    its cost and demands"
    if given["controller"]:
        margins = f"flexros design margins --controller {word(given['controller'])}"
        return f"{margins} --report loops.html    Bode, Nyquist, sensitivities and steps"
    return f"flexros design {word(given['method'])} --model {word(given['model'])} --out controller.yaml    keep it"


def _after_benchmark(given: Mapping[str, Any], _: int) -> str:
    if not given["controller"]:
        two = f"pid state_feedback --on {word(given['on'])}" if given["on"] else "pid_optimised lqg"
        return f"flexros benchmark {two}    evaluate two of them"
    names = " ".join(map(word, given["controller"]))
    if given["on"]:
        return f"flexros robot {word(given['on'])}    modes and zeros behind these figures"
    if not given["report"]:
        return f"flexros benchmark {names} --report benchmark.html    the same with pictures"
    return "flexros design structure --tune 200 --out tuned.yaml    tune one of your own"


def _after_robot_identified(given: Mapping[str, Any], _: int) -> str:
    return f"flexros robot {word(Path(given['out']) / 'identified.yaml')}    its modes; report.html is beside it"


def _after_identify_design(given: Mapping[str, Any], _: int) -> str:
    return f"flexros run {word(given['out'])} --out log, then flexros identify frf log --out frf.nc"


def _after_rigid(given: Mapping[str, Any], _: int) -> str:
    return (
        f"flexros gap ANOTHER_LOG --model {word(Path(given['out']) / 'identified.yaml')}    what the model still lacks"
    )


def _after_kinematics(given: Mapping[str, Any], _: int) -> str:
    out = Path(given["out"])
    if given["plan"]:
        return (
            f"flexros identify kinematics {word(out / 'poses.csv')} --model ROBOT --out found    once they are measured"
        )
    return f"flexros robot {word(out / 'robot.yaml')}    modes of the calibrated robot"


def _after_import_urdf(given: Mapping[str, Any], _: int) -> str:
    return f"flexros robot {word(given['out'])}    its numbers, and its modes with elastic gears"


def _after_import_mjcf(given: Mapping[str, Any], _: int) -> str:
    out = Path(given["out"])
    patch = Path(given["patch"] or out.with_name(f"{out.stem}_patch.yaml"))
    run = "flexros run diagnosis --model"
    if patch.exists() and patch.stat().st_mtime_ns >= out.stat().st_mtime_ns:  # written after the robot file
        return (
            f"{run} {word(patch)} --out log    a run of it; {word(out)} is the robot without the effects of the patch"
        )
    return f"{run} {word(out)} --out log    a run of it"


def _after_export(given: Mapping[str, Any], _: int) -> str:
    return f"flexros gap LOG --model {word(given['name'])}    compare it with a log of the other simulator"


def _after_fastest(given: Mapping[str, Any], _: int) -> str:
    changes = [word(change) for change in given["setting"]]
    if not any("time_law" in change for change in changes) and "time_optimal" not in given["scenario"]:
        changes.append("trajectory.time_law='{type: time_optimal}'")
    settings = "".join(f" --set {change}" for change in changes)
    return f"flexros run {word(given['scenario'])}{settings} --out log    run it"


def _after_learn(given: Mapping[str, Any], _: int) -> str:
    if given["out"]:
        return f"flexros analyze {word(given['out'])} --report report.html    the last run"
    return f"flexros learn {word(given['scenario'])} --out log    keep the last run"


def _after_replay(given: Mapping[str, Any], _: int) -> str:
    return f"flexros analyze {word(given['bag'])}    path error, tracking, timing of the same log"


def _after_doctor(_: Mapping[str, Any], code: int) -> str:
    return "mend what is BROKEN, then flexros doctor" if code else "flexros demo    circle test, diagnosis and repair"


GUIDES: dict[str, Guide] = {
    "robots": Guide(ROBOTS, "list the built-in robots", ("flexros robots",), always("flexros robot e12 --q 0,0.3,0")),
    "robot": Guide(
        ROBOTS,
        "modes, zeros and zero dynamics at a pose",
        ("flexros robot e12 --q 0,0.3,0", "flexros robot my_robot.yaml --bode bode.html"),
        _after_robot,
    ),
    "import-urdf": Guide(
        ROBOTS, "robot file from a URDF", ("flexros import-urdf arm.urdf --out arm.yaml",), _after_import_urdf
    ),
    "import-mjcf": Guide(
        ROBOTS, "robot file from an MJCF", ("flexros import-mjcf arm.xml --out arm.yaml",), _after_import_mjcf
    ),
    "export": Guide(
        ROBOTS,
        "numbers into MJCF, URDF, SDF or JSON",
        ("flexros export diagnosis/patch.yaml --to urdf --base arm.urdf --out repaired.urdf",),
        _after_export,
    ),
    "scenarios": Guide(
        RUNS, "list the built-in scenarios", ("flexros scenarios",), always("flexros run circle_dae    simulate one")
    ),
    "run": Guide(
        RUNS,
        "run a scenario and record it",
        (
            "flexros run circle_dae --out circle  # over ROS 2 topics where it is installed",
            "flexros run circle_dae --transport direct --effect payload_error@tool:relative=0.1",
            "flexros run circle_pd --realtime --set duration=10",
            "flexros run six_axis_moves --realtime --view  # a moving arm in the browser",
        ),
    ),
    "fastest": Guide(
        RUNS,
        "time-optimal motion on a path",
        (
            "flexros fastest elbow_moves",
            "flexros fastest elbow_time_optimal --set trajectory.time_law.smoothing=0.05    # less smooth",
        ),
        _after_fastest,
    ),
    "learn": Guide(
        RUNS, "iterative learning control", ("flexros learn circle_fj --trials 6 --out learned",), _after_learn
    ),
    "replay": Guide(RUNS, "play a log over ROS 2 topics", ("flexros replay circle --rate 0.5",), _after_replay),
    "demo": Guide(
        RUNS,
        "circle test, diagnosis, repair in 3 minutes",
        ("flexros demo --out demo",),
        always("open the report that is named above; then flexros scenarios"),
    ),
    "import": Guide(
        LOGS,
        "log of another recorder into a rosbag2 log",
        (
            "flexros import bag --model robot.yaml --out log  # proposes the mapping",
            "flexros import drive.yaml drive.csv --out log",
        ),
    ),
    "analyze": Guide(
        LOGS,
        "path error, tracking, timing, responses",
        ("flexros analyze circle --report report.html", "flexros analyze before after  # side by side"),
        _after_analyze,
    ),
    "gap": Guide(
        DIAGNOSE,
        "how far model and log are apart",
        ("flexros gap log --model e12", "flexros gap other --model e12 --patch diagnosis/patch.yaml"),
    ),
    "diagnose": Guide(
        DIAGNOSE,
        "which effects cause the gap, and the repair",
        (
            "flexros diagnose log --model e12 --out diagnosis",
            "flexros diagnose log --model e12 --effects coulomb_friction,backlash --time-limit 60 --out diagnosis",
        ),
    ),
    "compare": Guide(
        DIAGNOSE,
        "several diagnoses side by side",
        ("flexros compare before_service after_service --report compared.html",),
        _after_compare,
    ),
    "monitor": Guide(
        DIAGNOSE,
        "gap monitor on a log; its thresholds",
        ("flexros monitor log --model e12", "flexros monitor log --model e12 --calibrate thresholds.yaml"),
        _after_monitor,
    ),
    "view": Guide(
        LOGS,
        "log, robot or diagnosis as a moving arm in the browser",
        (
            "flexros view log                     # the arm, its deflection, path error and signals",
            "flexros view six_axis                # a robot: motors by sliders, modes in motion",
            "flexros view diagnosis --log log     # robot, nominal and repaired model side by side",
            "flexros view topics --model e12      # a robot that is running over ROS 2",
        ),
    ),
    "identify": Guide(IDENTIFY, "springs, dampers, friction by experiments", ()),
    "identify robot": Guide(
        IDENTIFY,
        "the whole procedure: design, run, fit",
        ("flexros identify robot two_mass --positions 2 --candidates 50 --transport direct --out found",),
        _after_robot_identified,
    ),
    "identify design": Guide(
        IDENTIFY,
        "choose positions, write the scenario",
        ("flexros identify design e12 --out experiment.yaml",),
        _after_identify_design,
    ),
    "identify frf": Guide(IDENTIFY, "frequency responses of a log", ("flexros identify frf log --out frf.nc",)),
    "identify fit": Guide(
        IDENTIFY,
        "parameters from frequency responses",
        ("flexros identify fit frf.nc --model e12 --out identified",),
        _after_robot_identified,
    ),
    "identify rigid": Guide(
        IDENTIFY,
        "masses and friction from torques",
        ("flexros identify rigid log --model e12 --out rigid",),
        _after_rigid,
    ),
    "identify axis": Guide(
        IDENTIFY,
        "gear, friction, masses of one axis",
        ("flexros identify axis log --model four_mass --out axis",),
        always("flexros gap LOG --model ROBOT    with these values in the robot file"),
    ),
    "identify kinematics": Guide(
        IDENTIFY,
        "lengths, zeros, compliances from poses",
        (
            "flexros identify kinematics --plan 60 --model six_axis --out plan",
            "flexros identify kinematics poses.csv --model six_axis --out found",
        ),
        _after_kinematics,
    ),
    "identify friction": Guide(
        IDENTIFY,
        "friction at constant speeds",
        ("flexros identify friction log",),
        always("flexros gap LOG --model ROBOT    with this friction in the robot file"),
    ),
    "design": Guide(
        CONTROL,
        "controllers for a robot, margins of loops",
        (
            "flexros design  # methods and their choices",
            "flexros design lqg --model four_mass --out lqg.yaml --report lqg.html",
            "flexros design margins --controller circle_dae",
        ),
        _after_design,
    ),
    "benchmark": Guide(
        CONTROL,
        "controllers on the feedback benchmark",
        ("flexros benchmark pid_optimised lqg.yaml --report benchmark.html",),
        _after_benchmark,
    ),
    "doctor": Guide(HERE, "check this installation", ("flexros doctor", "flexros doctor --json"), _after_doctor),
    "clean": Guide(
        HERE, "remove caches and temporary folders", ("flexros clean", "flexros clean --yes"), always("flexros doctor")
    ),
    "bench": Guide(
        PROOF, "speed against peers", ("flexros bench",), always("docs/results/benchmarks.md    figures and machine")
    ),
    "campaign": Guide(
        PROOF,
        "repeated identifications, hours",
        ("flexros campaign --out results --work work",),
        always("docs/results/index.md    what the campaigns showed"),
    ),
    "blind": Guide(PROOF, "check the diagnosis blindly", ()),
    "blind make": Guide(
        PROOF,
        "logs with hidden deviations",
        ("flexros blind make --out logs --truth truth --seed 7 --cases 0:50",),
        always("flexros blind run LOGS"),
    ),
    "blind run": Guide(
        PROOF,
        "diagnose without the truth",
        ("flexros blind run logs",),
        always("flexros blind score LOGS --truth TRUTH"),
    ),
    "blind score": Guide(
        PROOF,
        "compare with the truth",
        ("flexros blind score logs --truth truth",),
        always("docs/results/blind.md    our figures"),
    ),
}
"""What is said of each command, by its words."""


def guide_of(command: str, description: str = "") -> Guide:
    """Return what is said of a command; of one that is not listed, the first sentence of its description.

    Args:
        command: Its words without "flexros".
        description: Its docstring.
    """
    known = GUIDES.get(command)
    return known or Guide(OTHER, description.strip().partition("\n")[0].partition(".")[0], ())


def examples_text(guide: Guide) -> str:
    """Return the examples as the end of a help, lines kept as they are; empty without examples."""
    return "\n".join(["\b", "Examples:", *(f"  {example}" for example in guide.examples)]) if guide.examples else ""
