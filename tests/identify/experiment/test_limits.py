"""Limits, checked on the nominal model before an experiment."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario

pytestmark = pytest.mark.slow

Scenarios = Callable[..., Scenario]


def refusal(scenario: Scenario) -> str:
    with pytest.raises(InputError) as caught:
        _ = Experiment.prepare(scenario).reference
    return str(caught.value)


def test_torque_above_the_limit_is_refused_with_the_largest_amplitude(scenario_of: Scenarios) -> None:
    scenario = scenario_of().with_values({"controller.torque_limit": 800.0, "noise": False})
    text = refusal(scenario)
    found = re.fullmatch(
        r"scenario mine: identification\.positions\[\d\] \(.*\): motor_\d would reach a torque of -?\d[\d.e+]* Nm "
        r"on the nominal model, .* Nm of it without excitation, allowed are -?760 Nm; lower "
        r"identification\.excitation\.amplitude to 0\.\d+ times what is given, at most (0\.\d+)",
        text,
    )
    assert found is not None, text
    amplitude = float(found[1])
    allowed = scenario.with_values({"identification.excitation.amplitude": amplitude})
    effort = closed_loop(Experiment.prepare(allowed)).joint_commands.effort  # type: ignore[union-attr]
    assert effort is not None
    assert np.max(np.abs(effort)) == pytest.approx(760.0, rel=0.03)
    assert "torque" in refusal(scenario.with_values({"identification.excitation.amplitude": 1.02 * amplitude}))


def test_amplitude_per_motor_is_answered_per_motor(scenario_of: Scenarios) -> None:
    given = {"kind": "multisine", "period": 0.5, "lowest": 3.0, "highest": 40.0, "amplitude": [0.1, 0.2]}
    text = refusal(scenario_of(excitation=given).with_values({"controller.torque_limit": 1000.0}))
    found = re.search(r"at most \((0\.\d+), (0\.\d+)\)", text)
    assert found is not None, text
    assert float(found[2]) == pytest.approx(2.0 * float(found[1]), rel=0.01)


def test_position_limits_hold_for_excitation_and_slow_motion(scenario_of: Scenarios) -> None:
    inside = {"position": [[-0.5, 0.5], [0.0, 1.0]]}
    _ = Experiment.prepare(scenario_of(limits=inside)).reference
    far = scenario_of(limits=inside, slow_motion={"kind": "constant_speed", "speed": [0.6, 0.2]})
    assert re.search(
        r"motor_1 would reach a position of 0\.54\d* rad on the nominal model, 0\.54 rad of it without excitation, "
        r"allowed are 0\.5 rad; choose another position or a slower slow_motion",
        refusal(far),
    )


def test_speed_limit(scenario_of: Scenarios) -> None:
    text = refusal(scenario_of(limits={"speed": [1.0, 0.07]}, move={"speed": 0.06}))
    assert re.search(r"motor_2 would reach a speed of -?0\.\d+ rad/s .* allowed are -?0\.07 rad/s; lower", text)
    moving = refusal(scenario_of(limits={"speed": [1.0, 0.09]}))
    assert re.search(r"positions\[1\] .*: motor_2 moves there at up to 0\.\d+ rad/s, allowed are 0\.09; lower", moving)


def test_slow_motion_must_be_faster_than_the_excitation_unless_allowed(scenario_of: Scenarios) -> None:
    slow: dict[str, object] = {"kind": "constant_speed", "speed": 0.05}
    text = refusal(scenario_of(slow_motion=slow))
    assert re.search(
        r"motor_\d would reach a speed against the slow motion of .* allowed are -?0\.05 rad/s; lower", text
    )
    _ = Experiment.prepare(scenario_of(slow_motion={**slow, "allow_reversal": True})).reference


def test_load_that_is_too_much_at_rest_and_moves_that_are_too_fast() -> None:
    six_axis = load_scenario("identify_six_axis").with_values(
        {
            "identification.blocks": 1,
            "identification.positions": [[0, 0.2, 0.1, 0, 0.6, 0.3], [0.5, 0.5, -0.4, 0.8, 0.9, 0]],
        }
    )
    weak = refusal(six_axis.with_values({"controller.torque_limit": 4000.0}))
    assert re.search(
        r"positions\[0\] \(.*\): motor_[23] needs \d+ Nm to (move|hold the robot) there, allowed are 3800", weak
    )
    fast = refusal(six_axis.with_values({"identification.move": {"speed": 10.0, "acceleration": 40.0}}))
    assert re.search(
        r"motor_\d needs .* Nm to move there, allowed are .*; lower identification\.move\.acceleration", fast
    )


def test_controller_may_limit_the_torque_further() -> None:
    scenario = load_scenario("identify_six_axis")
    robot = Experiment.prepare(scenario).nominal
    assert np.array_equal(scenario.controller.command_limits(robot), robot.torque_limits)
    tighter = scenario.with_values({"controller.torque_limit": 1000.0}).controller
    np.testing.assert_array_equal(tighter.command_limits(robot), [1000, 1000, 1000, 1000, 1000, 800])


def test_linear_motor_has_its_units() -> None:
    scenario = Scenario.model_validate(
        {
            "name": "mine",
            "robot": "emps",
            "controller": {"kind": "cascade", "position_gain": 20, "speed_gain": 2000},
            "feedforward": {"method": "rigid"},
            "identification": {
                "positions": [[0.0]],
                "blocks": 1,
                "excitation": {"kind": "multisine", "lowest": 1.0, "highest": 20.0, "amplitude": 0.5},
            },
        }
    )
    assert re.search(r"motor_1 would reach a torque of -?\d+\.?\d* N on the nominal model", refusal(scenario))
