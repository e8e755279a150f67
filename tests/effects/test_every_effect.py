"""Properties of every effect, including future ones: members are discovered."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.compile.loop.arrays import LoopInputs, LoopResult, LoopState
from flexros.compile.loop.kernel import compile_loop
from flexros.effects import PlacedEffect, RobotWithEffects, effects, place_effects
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.robot import Robot, load_robot
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant import Plant, delayed_start
from flexros.simulate.plant_model import PlantModel
from tests.effects.unfitted import UNFITTED

pytestmark = pytest.mark.slow

NAMES = sorted(name for name in effects() if not name.startswith("servo_"))  # tests/effects/servos
ROBOT = load_robot("elbow")  # small, with two motors that act on each other, and gravity
SIZES = {
    "torque": 1000.0,
    "speed": 1.0,
    "angle": 1.0,
    "deflection": 2e-3,
    "torque/speed": 1000.0,
    "torque/angle": 1000.0,
}
"""Typical sizes in the runs below, for the ranges of the effects."""
SAMPLES = 80


def typical(name: str) -> PlacedEffect:
    """Place an effect at its last location on the robot, with parameters in the middle of their ranges."""
    kind = effects()[name]
    numbers = dict(UNFITTED.get(name, {}))
    for parameter, allowed in kind().fitted(ROBOT, kind().locations(ROBOT)[-1]).items():
        numbers[parameter] = float(np.sqrt(allowed.low * allowed.high)) * SIZES.get(allowed.scale, 1.0)
    return PlacedEffect(kind(**numbers), kind().locations(ROBOT)[-1])


@cache
def start() -> FloatArray:
    state = ROBOT.equilibrium()
    state[ROBOT.n_coordinates :] = [0.3, -0.05, 0.3, -0.05]
    return state


def torques() -> FloatArray:
    time = ROBOT.sample_time * np.arange(SAMPLES)[:, np.newaxis]
    swing = 600.0 * np.sin(2 * np.pi * 30.0 * time + np.array([0.0, 2.0]))
    torque: FloatArray = ROBOT.holding_torque(ROBOT.equilibrium()) + swing
    return torque


def run(model: PlantModel, parameters: FloatArray, engine: str = "machine_code", substeps: int = 1) -> LoopResult:
    reference = np.hstack([np.zeros((SAMPLES, 4)), torques()])
    kernel = compile_loop(
        model.functions(feed_through(2)),
        sample_time=ROBOT.sample_time,
        delay=model.delay,
        substeps=substeps,
        engine=engine,  # type: ignore[arg-type]
    )
    state: LoopState = delayed_start(
        model.start(start(), torques()[0], parameters), np.zeros(0), torques()[0], kernel.line_length
    )
    inputs = LoopInputs(reference=reference, parameters=parameters, gains=np.zeros(0))
    return kernel.run(state, SAMPLES, inputs, record_states=True)


@cache
def without_effect() -> LoopResult:
    return run(PlantModel(ROBOT), np.zeros(0))


@cache
def with_effect(name: str) -> tuple[RobotWithEffects, LoopResult]:
    placed = place_effects(ROBOT, [typical(name)], as_laws=True)
    return placed, run(PlantModel(placed.robot, placed.laws), np.zeros(0))


def outputs(result: LoopResult) -> FloatArray:
    assert result.states is not None
    assert result.tool_pose is not None
    return np.hstack([result.states[:, : 2 * ROBOT.n_coordinates], result.encoder, result.tool_pose])


def with_symbols(one: PlacedEffect) -> tuple[PlantModel, FloatArray]:
    """Return the plant with all parameters of the effect as symbols, and their values."""
    placed = place_effects(ROBOT, [one], as_laws=True)
    if placed.laws:
        numbers = {name: value for law in placed.laws for name, value in law.parameters.items()}
        return PlantModel(placed.robot, placed.laws, tuple(numbers)), np.array(list(numbers.values()))
    assert isinstance(one.effect, AbstractChangedValues)
    changed = one.effect.values(ROBOT, one.location)
    return PlantModel(ROBOT, (), tuple(changed)), np.array(list(changed.values()))


@pytest.mark.parametrize("name", NAMES)
def test_virtual_machine_with_symbols_equals_machine_code_with_numbers(name: str) -> None:
    _, numbers = with_effect(name)
    symbols = run(*with_symbols(typical(name)), engine="virtual_machine")
    np.testing.assert_allclose(outputs(symbols), outputs(numbers), rtol=1e-12, atol=1e-12)


def test_all_effects_together_and_twice_are_one_plant() -> None:
    every = [typical(name) for name in NAMES for _ in range(2)]
    placed = place_effects(ROBOT, every)
    model = PlantModel(placed.robot, placed.laws)
    names = tuple(name for law in model.laws for name in law.parameters)
    free = PlantModel(placed.robot, placed.laws, names)
    numbers = run(model, np.zeros(0))
    symbols = run(free, free.nominal_values, engine="virtual_machine")
    assert np.max(np.abs(outputs(numbers) - outputs(without_effect()))) > 1e-3
    np.testing.assert_allclose(outputs(symbols), outputs(numbers), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_effect_of_typical_size_is_seen(name: str) -> None:
    _, seen = with_effect(name)
    assert np.max(np.abs(outputs(seen) - outputs(without_effect()))) > 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_plant_stepped_sample_by_sample_equals_the_run_to_the_last_bit(name: str) -> None:
    placed, whole = with_effect(name)
    plant = Plant(placed.robot, ROBOT.sample_time, start(), torque=torques()[0], laws=placed.laws)
    assert whole.tool_pose is not None
    for k, torque in enumerate(torques()):
        assert np.array_equal(plant.measure(), whole.encoder[k])
        assert np.array_equal(plant.tool_pose(), whole.tool_pose[k])
        plant.advance(torque)


@pytest.mark.parametrize("name", NAMES)
def test_shorter_steps_converge(name: str) -> None:
    """A quarter of the step leaves at most a third of the error; the orders are tested effect by effect."""
    placed, rough = with_effect(name)
    model = PlantModel(placed.robot, placed.laws)
    fine, exact = (outputs(run(model, np.zeros(0), substeps=substeps)) for substeps in (4, 32))
    errors = [np.max(np.abs(result - exact)) for result in (outputs(rough), fine)]
    assert errors[0] < 1e-4
    assert errors[1] < max(errors[0] / 3, 1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_robot_that_starts_at_rest_stays_there(name: str) -> None:
    placed = place_effects(ROBOT, [typical(name)])
    model = PlantModel(placed.robot, placed.laws)
    rest = model.rest(placed.robot.equilibrium())
    command = model.command_at_rest(rest.state, rest.torque, np.zeros(0))
    plant = Plant(placed.robot, ROBOT.sample_time, rest.state, torque=command, laws=placed.laws)
    for _ in range(SAMPLES):
        plant.advance(command)
    assert np.max(np.abs(plant.state - rest.state)) < 1e-9


def neutral_effects(robot: Robot) -> list[PlacedEffect]:
    kinds = [kind() for kind in effects().values()]
    return [PlacedEffect(effect, location) for effect in kinds for location in effect.locations(robot)]


def test_neutral_effects_leave_the_run_as_it_is_to_the_last_bit() -> None:
    placed = place_effects(ROBOT, neutral_effects(ROBOT))
    again = run(PlantModel(placed.robot, placed.laws), np.zeros(0))
    assert np.array_equal(outputs(again), outputs(without_effect()))


@pytest.mark.parametrize("name", [name for name in NAMES if issubclass(effects()[name], AbstractLaw)])
def test_law_without_its_size_is_omitted_only_where_nothing_is_left_of_it(name: str) -> None:
    law = typical(name).effect
    assert isinstance(law, AbstractLaw)
    rest = law.model_copy(update={law.size: 0.0})
    places = [place for place in law.locations(ROBOT) if place != "base"]  # a ground needs an inertia
    left = run(*with_symbols(PlacedEffect(rest, places[-1])))  # symbols are never omitted
    assert rest.neutral == (np.max(np.abs(outputs(left) - outputs(without_effect()))) < 1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_effect_has_a_fingerprint_and_ranges(name: str) -> None:
    kind = effects()[name]
    assert len(kind.fingerprint.split()) > 5
    assert set(kind.ranges) <= set(kind.model_fields)
    assert kind.ranges or name in UNFITTED
    for allowed in kind.ranges.values():
        assert 0 < allowed.low < allowed.high
