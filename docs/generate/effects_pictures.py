"""Draw one picture per effect for effects.md: python docs/generate/effects_pictures.py [FOLDER]."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from effects_in_motion import CHANGED, Run, changed, magnitude, nominal, panel, run
from svg_picture import Curve, Panel, picture

from flexros.robot import Robot, load_robot

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

TWO_MASS, ELBOW, E12 = load_robot("two_mass"), load_robot("elbow"), load_robot("e12")
SLIDE = load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})
SERVO = load_robot("emps_servo").commanded_by("position")
MASS = SLIDE.parameters["body_1.mass"].value
SPEED, WAY, TIME = "speed [m/s]", "way [m]", "time [s]"
DISTURBANCE, FORCE = "disturbance force [N]", "force [N]"
ACCELERATION, FREQUENCY = "acceleration per torque [dB]", "frequency [Hz]"
MARKS = (5.0, 10.0, 20.0, 50.0)
Panels = Sequence[Panel]


def swing(size: float, frequency: float = 1.0) -> Callable[[float], list[float]]:
    """Return a force of one motor that swings."""
    return lambda time: [size * float(np.cos(2 * np.pi * frequency * time))]


def disturbance(moved: Run) -> FloatArray:
    """Return the disturbance force on the slide [N]."""
    return np.asarray(MASS * moved.acceleration(0) - moved.command[:, 0])


def of_slide(*texts: str, size: float = 150.0, frequency: float = 1.0, duration: float = 2.0) -> Run:
    """Move the slide to and fro."""
    return run(SLIDE, texts, swing(size, frequency), duration)


def over_speed(text: str, size: float = 150.0) -> Panels:
    """Draw the disturbance force over the speed."""
    moved = of_slide(*text.split(), size=size)
    inner = slice(5, -5)
    speed = moved.speed[inner, 0]
    return [
        panel("on a slide", SPEED, DISTURBANCE, [nominal(speed, 0 * speed), changed(speed, disturbance(moved)[inner])])
    ]


def over_way(text: str) -> Panels:
    """Draw the disturbance force over the way."""
    moved = of_slide(text)
    inner = slice(5, -5)
    way = moved.position[inner, 0]
    return [panel("on a slide", WAY, DISTURBANCE, [nominal(way, 0 * way), changed(way, disturbance(moved)[inner])])]


def over_time(text: str, duration: float = 2.0) -> Panels:
    """Draw the disturbance force over time."""
    moved = of_slide(text, duration=duration)
    inner = slice(5, -5)
    time = moved.time[inner]
    return [
        panel(
            "on a slide",
            TIME,
            DISTURBANCE,
            [nominal(time, 0 * time), changed(time, disturbance(moved)[inner], width=1.0)],
        )
    ]


def over_load(text: str) -> Panels:
    """Draw the disturbance torque at the motor of two masses over the torque of its gear."""
    moved = run(TWO_MASS, [text], swing(40.0, 0.5), 4.0)
    inner = slice(5, -5)
    load, rotor = (6.0 * moved.acceleration(0))[inner], (4.0 * moved.acceleration(1))[inner]
    torque = load + rotor - moved.command[inner, 0]
    return [
        panel(
            "two masses",
            "torque of the gear [Nm]",
            "disturbance torque [Nm]",
            [nominal(load, 0 * load), changed(load, torque)],
        )
    ]


def over_command(text: str) -> Panels:
    """Draw the acting force over the commanded one."""
    moved = of_slide(text)
    inner = slice(5, -5)
    acting = MASS * moved.acceleration(0)[inner]
    command = moved.command[inner, 0]
    curves = [nominal(command, command), changed(command, acting)]
    return [panel("on a slide", "commanded force [N]", "acting force [N]", curves)]


def step_response(text: str) -> Panels:
    """Draw the acting force over time after steps of the commanded one."""
    moved = run(SLIDE, [text], lambda time: [50.0 * (time % 0.04 < 0.02)], 0.1)
    acting = MASS * np.diff(moved.speed[:, 0]) / SLIDE.sample_time
    time = moved.time[:-1]
    return [panel("on a slide", TIME, FORCE, [nominal(time, moved.command[:-1, 0]), changed(time, acting)])]


def servo_step(text: str) -> Panels:
    """Draw the way of a slide under its servo after a step of the commanded position, and along a commanded ramp."""
    panels = []
    for title, wanted in (
        ("step of the command", lambda _: [1e-4]),
        ("ramp of the command", lambda time: [2e-3 * time]),
    ):
        still, moved = (run(SERVO, texts, wanted, 0.08) for texts in ([], [text]))
        curves = [nominal(still.time, 1e6 * still.position[:, 0]), changed(moved.time, 1e6 * moved.position[:, 0])]
        panels.append(panel(title, TIME, "way [um]", curves))
    return panels


def over_rotor_angle(text: str) -> Panels:
    """Draw the disturbance torque over the angle of a rotor, at two speeds."""
    curves = []
    for speed, colour in ((0.6, CHANGED), (1.2, "#1f5fa8")):
        moved = run(
            ELBOW.with_values({"motor_1.viscous_friction": 0.0}), [text], hold_elbow, 0.13 / speed, elbow_at(speed)
        )
        turns = 120.0 * moved.position[:, 2] / (2 * np.pi)
        plain = run(ELBOW.with_values({"motor_1.viscous_friction": 0.0}), [], hold_elbow, 0.13 / speed, elbow_at(speed))
        torque = 60.0 * (moved.acceleration(2) - plain.acceleration(2))
        curves.append(Curve(turns[2:-2] - turns[0], torque[2:-2], f"{speed:g} rad/s at the arm", colour))
    return [panel("at the elbow", "turns of the rotor [1]", "disturbance torque [Nm]", curves, (0, 0.5, 1, 1.5, 2))]


def hold_elbow(time: float) -> list[float]:
    """Return the torques that hold the elbow at its home."""
    del time
    return [float(value) for value in ELBOW.holding_torque(ELBOW.equilibrium())]


def elbow_at(speed: float) -> list[float]:
    """Return the elbow's home, all parts of the first axis at a speed."""
    state = ELBOW.equilibrium()
    state[[4, 6]] = speed
    return [float(value) for value in state]


def encoder_error(text: str) -> Panels:
    """Draw measured minus true position over the true one."""
    moved = run(TWO_MASS, [text], lambda time: [0.5 if time < 1 else -0.5], 2.0)
    true = moved.position[:, 1]
    return [
        panel(
            "two masses", "motor angle [rad]", "measured - true [rad]", [changed(true, moved.encoder[:, 0] - true, "")]
        )
    ]


def staircase(text: str) -> Panels:
    """Draw measured and true position over time."""
    moved = run(TWO_MASS, [text], lambda time: [0.5 if time < 0.5 else -0.5], 1.0)
    curves = [nominal(moved.time, moved.position[:, 1], "true"), changed(moved.time, moved.encoder[:, 0], "measured")]
    return [panel("two masses", TIME, "motor angle [rad]", curves)]


def responses(text: str, robot: Robot = TWO_MASS) -> Panel:
    """Draw the frequency response of the first motor."""
    frequency = np.geomspace(5, 50, 500)
    curves = [
        nominal(frequency, magnitude(robot, [], frequency)),
        changed(frequency, magnitude(robot, [text], frequency)),
    ]
    return panel(text.partition(":")[0], FREQUENCY, ACCELERATION, curves, MARKS, logarithmic=True)


def gear_loop(text: str, sizes: Sequence[float], title: str) -> Panel:
    """Draw the torque in the gear of two masses over its deflection, at several amplitudes."""
    curves = []
    for size, colour in zip(sizes, (CHANGED, "#1f5fa8", "#3a8f5c")):
        held = TWO_MASS.with_values({"body_1.rz.damping": 300.0, "motor_1.inertia": 1.0})
        moved = run(held, [text], swing(size, 0.5), 6.0)
        deflection = 1e3 * (moved.position[:, 1] - moved.position[:, 0])
        torque = 6.0 * moved.acceleration(0)
        last = slice(len(torque) * 2 // 3, -3)
        curves.append(Curve(deflection[last], torque[last], "", colour))
    reach = 1e3 * max(sizes) * 0.85 / 6e4
    straight = np.array([-reach, reach])
    curves.append(nominal(straight, 60.0 * straight))
    return panel(title, "deflection [mrad]", "torque to the arm [Nm]", curves)


def backlash(text: str) -> Panels:
    """Draw torque over deflection, and motor and arm passing the gap."""
    moved = run(TWO_MASS, [text], lambda time: [8.0 if time < 0.15 else -8.0], 0.5)
    curves = [nominal(moved.time, moved.speed[:, 0], "arm"), changed(moved.time, moved.speed[:, 1], "motor")]
    return [
        gear_loop(text, (40.0, 15.0), "slow swing"),
        panel("reversed torque", TIME, "speed [rad/s]", curves),
    ]


def transmission(text: str) -> Panels:
    """Draw the deflection of the gear over the motor angle at a slow and a resonant speed."""
    curves = []
    heavy = TWO_MASS.with_values({"motor_1.inertia": 4e5})
    for speed, label, colour in ((0.5, "slow", CHANGED), (2.4, "near the resonance", "#1f5fa8")):
        moved = run(heavy, [text], lambda time: [0.0], 12.0 / speed, [0.0, 0.0, speed, speed])
        late = moved.position[:, 1] > moved.position[-1, 1] - 1.0
        angle = moved.position[late, 1] - moved.position[late, 1][0]
        curves.append(Curve(angle, 1e3 * (moved.position[late, 0] - moved.position[late, 1]), label, colour))
    return [panel("two masses, motor at constant speed", "motor angle [rad]", "arm - motor [mrad]", curves)]


def holding(text: str) -> Panels:
    """Draw the torque that holds the second link of the elbow over its angle."""
    from effects_in_motion import with_effects

    from flexros.simulate.plant_model import PlantModel

    angles = np.linspace(-1.5, 1.5, 61)
    curves = []
    for texts, draw in (([], nominal), ([text], changed)):
        placed = with_effects(ELBOW, *texts)
        model = PlantModel(placed.robot, placed.laws)
        torques = [model.rest(ELBOW.equilibrium([0.0, angle])).torque[1] for angle in angles]
        curves.append(draw(angles, np.array(torques)))
    return [panel("second link of the elbow", "angle [rad]", "torque at rest [Nm]", curves)]


def holding_by_reading(text: str) -> Panels:
    """Draw the torque that holds the second link of the elbow over its measured angle."""
    angles, offset = np.linspace(-1.5, 1.5, 61), float(text.partition("=")[2])
    torques = np.array([ELBOW.holding_torque(ELBOW.equilibrium([0.0, angle]))[1] for angle in angles])
    curves = [nominal(angles, torques), changed(angles + offset, torques)]
    return [panel("second link of the elbow", "measured angle [rad]", "torque at rest [Nm]", curves)]


def over_angle(text: str) -> Panels:
    """Draw the disturbance torque at the second motor of the elbow over its angle."""
    from effects_in_motion import with_effects

    from flexros.simulate.plant_model import PlantModel

    angles, motor = np.linspace(-1.5, 1.5, 61), ELBOW.n_coordinates + ELBOW.motor_rows[1]
    model, inertia = PlantModel(ELBOW, with_effects(ELBOW, text).laws), ELBOW.parameters["motor_2.inertia"].value
    torque = []
    for angle in angles:
        at = (ELBOW.equilibrium([0.0, angle]), np.zeros(2), np.zeros(6), np.zeros(0))
        torque.append(inertia * float((model.derivative(*at) - ELBOW.model.derivative(*at))[motor]))
    curves = [nominal(angles, 0 * angles), changed(angles, np.array(torque))]
    return [panel("second motor of the elbow", "angle [rad]", "disturbance torque [Nm]", curves)]


def tool_error(text: str) -> Panels:
    """Draw the error of the measured tool over the angle of the first link."""

    def turned(time: float) -> list[float]:
        return [1500.0 if time < 0.5 else -1500.0, 0.0]

    start = [0.0, 0.3, 0.0, 0.0, 0.3, *[0.0] * 5]
    with_error, without = run(E12, [text], turned, 1.0, start), run(E12, [], turned, 1.0, start)
    difference = 1e3 * (with_error.tool - without.tool)
    angle = without.position[:, 0]
    curves = [Curve(angle, difference[:, 0], "x", CHANGED), Curve(angle, difference[:, 2], "z", "#1f5fa8")]
    return [panel("e12", "angle of the first link [rad]", "measured - expected tool [mm]", curves)]


def presliding(text: str) -> Panels:
    """Draw force over way in small motion, and over speed in large motion."""
    small = run(SLIDE, [text], lambda time: [18.0 * float(np.sin(2 * np.pi * time) * np.exp(-0.15 * time))], 4.0)
    curve = changed(1e6 * small.position[5:-5, 0], disturbance(small)[5:-5], "")
    return [panel("below breakaway", "way [um]", DISTURBANCE, [curve]), *over_speed(text)]


DRAWINGS: dict[str, tuple[Callable[[str], Panels], str]] = {
    "actuator_lag": (step_response, "actuator_lag@motor_1:time_constant=3e-3"),
    "base_tilt": (holding, "base_tilt@base:y=0.2"),
    "backlash": (backlash, "backlash@motor_1:gap=1e-3"),
    "coulomb_friction": (over_speed, "coulomb_friction@motor_1:level=20,asymmetry=0.2"),
    "counterbalance": (over_angle, "counterbalance@motor_2:cosine=60,sine=20"),
    "damping_error": (lambda text: [responses(text)], "damping_error@body_1.rz:relative=2"),
    "delay": (step_response, "delay@all:time=3e-3"),
    "encoder_eccentricity": (encoder_error, "encoder_eccentricity@motor_1:amplitude=1e-4,order=300"),
    "encoder_offset": (holding_by_reading, "encoder_offset@motor_2:offset=0.2"),
    "encoder_quantization": (staircase, "encoder_quantization@motor_1:step=2e-3"),
    "body_difference": (lambda text: [responses(text)], "body_difference@body_1:mass=4"),
    "extra_mode": (
        lambda text: [responses(f"extra_mode@{place}:{text}") for place in ("tool", "base")],
        "frequency=12,ratio=0.3",
    ),
    "friction_curve": (
        over_speed,
        "friction_curve@motor_1:standstill=8,speed_10=2,speed_25=18,speed_50=6,speed_75=10,speed_100=12,speed=0.25",
    ),
    "friction_over_position": (
        over_way,
        "friction_over_position@motor_1:level_1=8,level_2=8,level_3=10,level_4=25,level_5=20,level_6=6,level_7=4,level_8=4,"
        "low=-0.04,high=0.065",
    ),
    "friction_drift": (lambda text: over_time(text, 12.0), "friction_drift@motor_1:coulomb=20,time_constant=4"),
    "gravity_error": (holding, "gravity_error@body_2:relative=0.2"),
    "hysteresis": (
        lambda text: [gear_loop(text, (40.0, 15.0, 5.0), "slow swing, three amplitudes")],
        "hysteresis@motor_1:level=8,angle=1e-4",
    ),
    "center_error": (holding, "center_error@body_2:z=0.05"),
    "inertia_error": (lambda text: [responses(text)], "inertia_error@body_1:relative=0.4"),
    "kinematic_error": (tool_error, "kinematic_error@body_2:length=1e-3"),
    "load_dependent_friction": (over_load, "load_dependent_friction@motor_1:share=0.15"),
    "motor_inertia_error": (lambda text: [responses(text)], "motor_inertia_error@motor_1:relative=0.4"),
    "rotor_inertia": (lambda text: [responses(text)], "rotor_inertia@motor_1:added=1.6"),
    "nonlinear_stiffness": (
        lambda text: [gear_loop(text, (60.0, 25.0), "slow swing, two amplitudes")],
        "nonlinear_stiffness@body_1.rz:relative=1.5,knee=3e-4",
    ),
    "payload_error": (lambda text: [responses(text)], "payload_error@tool:relative=0.4"),
    "presliding_friction": (
        presliding,
        "presliding_friction@motor_1:level=20,extra=10,velocity=0.05,stiffness=1e6,damping=300",
    ),
    "servo_command_lag": (servo_step, "servo_command_lag@motor_1:time_constant=0.01"),
    "servo_damping_error": (servo_step, "servo_damping_error@motor_1:relative=-0.4"),
    "servo_feedforward_error": (servo_step, "servo_feedforward_error@motor_1:share=0.6"),
    "servo_integral": (servo_step, "servo_integral@motor_1:gain=6e7"),
    "servo_stiffness_error": (servo_step, "servo_stiffness_error@motor_1:relative=-0.4"),
    "spring_curve": (
        lambda text: [gear_loop(text, (60.0, 25.0), "slow swing, two amplitudes")],
        "spring_curve@body_1.rz:positive_50=5,positive_75=15,positive_100=30,negative_25=-8,negative_50=-5,"
        "negative_75=5,negative_100=5,low=-1e-3,high=1e-3",
    ),
    "stiffness_error": (lambda text: [responses(text)], "stiffness_error@body_1.rz:relative=-0.3"),
    "stribeck_friction": (
        over_speed,
        "stribeck_friction@motor_1:extra=20,velocity=0.05 coulomb_friction@motor_1:level=10",
    ),
    "tool_load": (lambda text: [responses(text)], "tool_load@tool:mass=4"),
    "torque_bias": (over_time, "torque_bias@motor_1:level=10"),
    "torque_curve": (
        over_way,
        "torque_curve@motor_1:torque_1=10,torque_2=10,torque_3=-5,torque_5=15,torque_6=15,torque_8=-20,low=0,high=0.08",
    ),
    "torque_drift": (
        lambda text: over_time(text, 12.0),
        "torque_drift@motor_1:torque_1=2,torque_2=10,torque_3=14,torque_4=12,torque_5=12,torque_6=20,end=10",
    ),
    "torque_gain_error": (over_command, "torque_gain_error@motor_1:relative=-0.2"),
    "torque_ripple": (over_rotor_angle, "torque_ripple@motor_1:amplitude=5,order=6"),
    "torque_saturation": (over_command, "torque_saturation@motor_1:limit=90"),
    "transmission_error": (transmission, "transmission_error@motor_1:amplitude=2e-4,order=40"),
    "viscous_friction": (over_speed, "viscous_friction@motor_1:coefficient=80,asymmetry=0.4"),
}
"""Pictures of each effect, with its parameters."""


def pictures() -> dict[str, str]:
    """Draw all pictures.

    Returns:
        SVG text by name of the effect.
    """
    return {name: picture([draw(text)]) for name, (draw, text) in DRAWINGS.items()}


if __name__ == "__main__":
    folder = (
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "reference" / "pictures" / "effects"
    )
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pictures().items():
        (folder / f"{name}.svg").write_text(text, encoding="utf-8")
