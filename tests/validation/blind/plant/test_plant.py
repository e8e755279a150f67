"""The simulator of the blind check agrees with FlexROS where nothing is hidden, and its laws do what they are named."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.compile import LoopInputs, compile_loop
from flexros.control.context import LoopContext
from flexros.control.pid import Pid
from flexros.identify.design.default_controller import default_controller
from flexros.robot import Robot, load_robot
from flexros.simulate.plant import delayed_start
from flexros.simulate.plant_model import PlantModel
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.draw.nominal_filter import NominalFilter
from flexros.validation.blind.plant.laws import LAWS
from flexros.validation.blind.plant.plant import BlindInputs, BlindPlant, BlindRun

pytestmark = pytest.mark.slow

STEP = 5e-4


def swing(robot: Robot, duration: float = 1.5) -> BlindInputs:
    """Swing all motors about home, starting at rest."""
    time = np.arange(round(duration / STEP)) * STEP
    rest = robot.equilibrium(robot.home)[list(robot.motor_rows)]
    size = 5.0 if robot.spec.coordinates == "motor" else 0.2
    position = rest + size * (1 - np.cos(2 * np.pi * time))[:, None] ** 2 * np.ones(robot.n_motors)
    speed = np.gradient(position, STEP, axis=0)
    still = np.zeros_like(position)
    torque = np.tile(robot.holding_torque(robot.equilibrium(robot.home)), (len(time), 1))
    reference = np.hstack([position, speed, torque])
    return BlindInputs(reference, still, still, np.zeros(len(time)), np.zeros(len(time)))


def simulated(robot: Robot, *deviations: Deviation, inputs: BlindInputs | None = None) -> BlindRun:
    plant = BlindPlant(robot, deviations, default_controller(robot, STEP), STEP)
    return plant.run(swing(robot) if inputs is None else inputs)


def hidden(effect: str, location: str, **parameters: float) -> Deviation:
    return Deviation(effect=effect, location=location, parameters=parameters)


def by_library(robot: Robot, inputs: BlindInputs) -> FloatArray:
    """Motor positions of the same closed loop, simulated by FlexROS."""
    law, model, context = default_controller(robot, STEP), PlantModel(robot), LoopContext(robot, STEP)
    kernel = compile_loop(model.functions(law.function(context)), sample_time=STEP, substeps=4, delay=robot.delay)
    rest = robot.equilibrium(robot.home, motor_position=inputs.reference[0, : robot.n_motors])
    state = delayed_start(model.start(rest), law.initial_state(context), robot.holding_torque(rest), kernel.line_length)
    gains = law.gains(context)
    return kernel.run(state, len(inputs.reference), LoopInputs(reference=inputs.reference, gains=gains)).encoder


@pytest.mark.parametrize("name", ["four_mass_linear", "elbow", "e12"])
def test_without_deviations_it_is_the_robot_of_the_library(name: str) -> None:
    robot = load_robot(name)
    inputs = swing(robot)
    ours, theirs = simulated(robot, inputs=inputs).encoder, by_library(robot, inputs)
    assert np.max(np.abs(ours - theirs)) < 1e-7 * np.ptp(theirs)


def test_every_deviation_has_a_law_and_is_nothing_at_size_zero_of_the_relative_errors() -> None:
    robot = load_robot("four_mass_linear")
    nothing = simulated(robot).encoder
    for effect in ("stiffness_error", "damping_error"):
        same = simulated(robot, hidden(effect, "body_2.rz", relative=0.0)).encoder
        assert np.allclose(same, nothing, rtol=0, atol=1e-12)
    assert len(LAWS) == 33


def test_delay_of_whole_samples_moves_the_command_by_samples() -> None:
    robot = load_robot("four_mass_linear")
    inputs, law = swing(robot, 0.3), default_controller(robot, STEP)
    longer = robot.with_values({"delay": robot.delay + 2 * STEP})
    theirs = BlindPlant(longer, (), law, STEP).run(inputs).encoder
    ours = BlindPlant(robot, (hidden("delay", "motor_1", time=2 * STEP),), law, STEP).run(inputs).encoder
    assert np.allclose(ours, theirs, rtol=0, atol=1e-10)


def test_coulomb_friction_holds_a_motor_that_is_pushed_with_less() -> None:
    robot = load_robot("four_mass_linear")
    inputs = swing(robot, 0.5)
    inputs.reference[:] = 0.0
    inputs.reference[:, 2] = 0.5  # feedforward torque
    stuck = simulated(robot, hidden("coulomb_friction", "motor_1", level=20.0, asymmetry=0.0), inputs=inputs)
    free = simulated(robot, inputs=inputs)
    assert np.max(np.abs(stuck.encoder)) < robot.encoder_noise[0]
    assert np.max(np.abs(free.encoder)) > 10 * robot.encoder_noise[0]


def test_backlash_lets_the_gear_move_within_its_gap() -> None:
    robot = load_robot("four_mass_linear")
    gap = 0.05
    loose, firm = simulated(robot, hidden("backlash", "motor_1", gap=gap)), simulated(robot)
    twist = [run.states[:, robot.motor_rows[0]] - run.states[:, 0] for run in (loose, firm)]
    assert gap * 0.8 < np.ptp(twist[0]) - np.ptp(twist[1]) < gap * 1.6


def test_mode_at_the_base_adds_a_coordinate_and_keeps_the_motors() -> None:
    robot = load_robot("e12")
    mode = hidden("extra_mode", "base", frequency=15.0, ratio=1.0, damping=0.02)
    plant = BlindPlant(robot, (mode,), default_controller(robot, STEP), STEP)
    assert plant.robot.n_arm == robot.n_arm + 1
    assert plant.run(swing(robot, 0.2)).encoder.shape[1] == robot.n_motors


def test_error_of_the_gear_loses_no_power() -> None:
    robot = load_robot("four_mass_linear").with_values(
        {f"body_{k}.rz.damping": 0.0 for k in (1, 2, 3)}
        | {f"body_{k}.viscous_friction": 0.0 for k in (1, 2, 3)}
        | {"motor_1.viscous_friction": 0.0}
    )
    wave = hidden("transmission_error", "motor_1", amplitude=0.02, order=3.0, phase=0.4)
    plant = BlindPlant(robot, (wave,), Pid(kp=0.0), STEP)
    inputs = swing(robot, 1.0)
    inputs.reference[:, 2] = np.where(np.arange(len(inputs.lost)) < 200, 1.0, 0.0)  # pushed, then left alone
    states = plant.run(inputs).states[400:]
    n, turn = robot.n_coordinates, states[:, 3] * 3.0 + 0.4
    kinetic, potential = (np.asarray(one).ravel() for one in robot.model.energy(states[:, :n].T, states[:, n:].T, []))
    bent = states[:, 3] - states[:, 0]
    spring = robot.parameters["body_1.rz.stiffness"].value / 2
    whole = kinetic + potential + spring * ((bent - 0.02 * np.sin(turn)) ** 2 - bent**2)
    assert np.ptp(whole) < 1e-6 * np.mean(whole)


def test_lag_shorter_than_a_tick_comes_as_late_as_a_delay_of_its_time() -> None:
    robot, short = load_robot("four_mass_linear"), 2e-5
    inputs = swing(robot, 0.1)
    inputs.reference[:] = 0.0
    inputs.reference[:, 2] = 1.0
    laws = ((), (hidden("actuator_lag", "motor_1", time_constant=short),), (hidden("delay", "motor_1", time=short),))
    neither, lag, delay = (BlindPlant(robot, law, Pid(kp=0.0), STEP).run(inputs).states[-1] for law in laws)
    assert np.linalg.norm(lag - delay) < 0.01 * np.linalg.norm(delay - neither)


def test_point_mass_at_the_tool_moves_in_the_plane() -> None:
    robot = load_robot("e12")
    mode = hidden("extra_mode", "tool", frequency=15.0, ratio=0.1, damping=0.02, point=1.0)
    plant = BlindPlant(robot, (mode,), default_controller(robot, STEP), STEP)
    assert plant.robot.arm_names[-2:] == ("body_4.tx", "body_4.tz")
    assert np.all(np.isfinite(plant.run(swing(robot, 0.2)).encoder))


def test_quantized_encoder_shows_multiples_of_its_step() -> None:
    run = simulated(load_robot("four_mass_linear"), hidden("encoder_quantization", "motor_1", step=1e-3))
    steps = run.encoder / 1e-3
    assert np.allclose(steps, np.round(steps), atol=1e-6)


def test_filter_of_the_robot_follows_it_and_loses_a_deviation_in_proportion_to_its_square() -> None:
    robot = load_robot("four_mass_linear")
    tracker = NominalFilter(robot, STEP)
    gains = []
    for level in (0.0, 1e-3, 2e-3):
        run = simulated(robot, hidden("torque_bias", "motor_1", level=level))
        gains.append(tracker.expected_gain(run.encoder, run.command))
    assert gains[0] < 1e-3
    assert gains[2] / gains[1] == pytest.approx(4.0, rel=0.01)


def test_tolerance_takes_from_the_gain_what_its_parameters_explain() -> None:
    robot = load_robot("four_mass_linear")
    run = simulated(robot, hidden("stiffness_error", "body_1.rz", relative=0.002))
    exact = NominalFilter(robot, STEP).expected_gain(run.encoder, run.command)
    within = NominalFilter(robot, STEP, {"body_1.rz.stiffness": 0.002}).expected_gain(run.encoder, run.command)
    assert within < 2.0 < 10.0 < exact
