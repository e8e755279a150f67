"""Backlash: nothing in the gap, the nominal gear on a flank, no pull, no energy from nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects.gear.backlash import Backlash
from flexros.robot import load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import GearLaw, halving_errors, laws_of, run, still

pytestmark = pytest.mark.slow

TWO_MASS = load_robot("two_mass")
FOUR_MASS = load_robot("four_mass")
ELBOW = load_robot("elbow")


@pytest.mark.parametrize("rate", [-2.0, 0.0, 3.0])
def test_nothing_is_transmitted_inside_the_gap(rate: float) -> None:
    law = GearLaw(Backlash(gap=0.02), stiffness=1e4, damping=30.0, cubic=1e6)
    for deflection in (-0.0099, 0.0, 0.004):
        assert law.torques(deflection, np.zeros(1), rate) == (0.0, 0.0)


def test_flanks_push_and_never_pull() -> None:
    law = GearLaw(Backlash(gap=0.02), stiffness=1e4, damping=30.0)
    on_flank = np.array([0.003])
    assert law.torques(0.013, on_flank, 0.5) == pytest.approx((30.0 + 15.0, -45.0))
    assert law.torques(0.013, on_flank, -0.5) == pytest.approx((30.0 - 15.0, -15.0))
    assert law.torques(0.013, on_flank, -1.5) == (0.0, 0.0)  # the damper alone would pull by 15 Nm
    assert law.torques(-0.013, -on_flank, -0.5) == pytest.approx((-45.0, 45.0))
    assert law.torques(-0.013, -on_flank, 1.5) == (0.0, 0.0)


def test_twist_that_is_left_decays_by_the_damper() -> None:
    law = GearLaw(Backlash(gap=0.02), stiffness=1e4, damping=30.0)
    left = law.after(0.002, np.array([1e-3]), step=1e-3)
    assert left == pytest.approx(1e-3 * np.exp(-1e4 / 30.0 * 1e-3), rel=1e-9)
    undamped = GearLaw(Backlash(gap=0.02), stiffness=1e4)
    assert abs(undamped.after(0.002, np.array([1e-3]), step=1e-3)) < 1e-20
    assert undamped.after(0.0103, np.array([1e-3]), step=1e-3) == pytest.approx(3e-4)


def test_motor_in_the_gap_accelerates_alone() -> None:
    path = run(TWO_MASS, laws_of(TWO_MASS, "backlash@motor_1:gap=0.02"), 60, lambda time: np.array([20.0]))
    time = np.arange(61) * TWO_MASS.sample_time
    np.testing.assert_allclose(path[:, 1], 20.0 / 4.0 * time**2 / 2, atol=1e-15)
    assert not np.any(path[:, 0])


def test_stiffness_on_a_flank_is_the_nominal_one() -> None:
    robot = FOUR_MASS
    law = laws_of(robot, "backlash@motor_1:gap=0.01")
    start = np.zeros(2 * robot.n_coordinates)
    start[3] = 0.03  # on the second piece of the spring
    with_gap = PlantModel(robot, law)
    plain = PlantModel(robot)
    shifted = start.copy()
    shifted[3] += 0.005
    nothing = (np.zeros(1), np.zeros(6), np.zeros(0))
    state = with_gap.start(shifted)
    np.testing.assert_allclose(
        with_gap.derivative(state, *nothing).full()[: len(start)], plain.derivative(start, *nothing).full(), rtol=1e-12
    )


def test_load_that_keeps_one_flank_in_touch_makes_it_vanish() -> None:
    law = laws_of(ELBOW, "backlash@motor_1:gap=2e-3", "backlash@motor_2:gap=1e-3")
    model = PlantModel(ELBOW, law)
    plain = ELBOW.equilibrium(ELBOW.home)
    rest = model.rest(plain)
    signs = np.sign(ELBOW.holding_torque(plain))
    arm = rest.state[:2]  # the arm sags through half the gaps
    motor = plain.copy()
    motor[:2] = arm
    motor[2:4] = arm + (plain[2:4] - plain[:2])
    nominal = ELBOW.equilibrium(motor_position=rest.state[2:4] - signs * np.array([1e-3, 0.5e-3]), q_a=arm)
    np.testing.assert_allclose(nominal[:2], arm, atol=1e-12)
    hold = rest.torque
    np.testing.assert_allclose(hold, ELBOW.holding_torque(nominal), rtol=1e-9)

    def shaken(time: float) -> FloatArray:
        return hold + np.array([20.0, 10.0]) * np.sin(40 * time)

    path, ideal = run(ELBOW, law, 300, shaken, rest.state), run(ELBOW, (), 300, shaken, nominal)
    np.testing.assert_allclose(path[:, :2], ideal[:, :2], atol=1e-11)
    np.testing.assert_allclose(path[:, 4:], ideal[:, 4:], atol=1e-9)
    assert np.max(np.abs(ideal[:, :2] - ideal[0, :2])) > 1e-4


def nordin_gutman(gap: float, torque: float, time: float, steps: int) -> FloatArray:
    """Integrate the exact model with two_mass in very small steps: the state [q_a, q_m, v_a, v_m] at the end."""
    k, c, inertia, rotor = 6e4, 30.0, 6.0, 4.0
    qa = qm = va = vm = angle = 0.0
    h = time / steps
    for n in range(steps):
        u = torque if n < steps / 2 else -torque
        deflection, rate = qm - qa, vm - va
        slide = rate + k / c * (deflection - angle)
        slide = min(slide, 0.0) if angle >= gap / 2 else max(slide, 0.0) if angle <= -gap / 2 else slide
        shaft = k * (deflection - angle) + c * (rate - slide)
        va, vm = va + h * shaft / inertia, vm + h * (u - shaft) / rotor
        qa, qm = qa + h * va, qm + h * vm
        angle = min(max(angle + h * slide, -gap / 2), gap / 2)
    return np.array([qa, qm, va, vm])


def test_it_is_the_exact_model_of_nordin_and_gutman() -> None:
    gap, samples = 2e-4, 200

    def pushed(time: float) -> FloatArray:
        return np.array([15.0 if time < 0.0999 else -15.0])

    path = run(TWO_MASS, laws_of(TWO_MASS, f"backlash@motor_1:gap={gap}"), samples, pushed)
    exact = nordin_gutman(gap, 15.0, samples * TWO_MASS.sample_time, 200_000)
    plain = run(TWO_MASS, (), samples, pushed)[-1]
    assert np.max(np.abs(path[-1] - exact)[:2]) < 0.01 * np.max(np.abs(plain - exact)[:2])


def test_small_gap_tends_to_the_nominal_gear() -> None:
    def waving(time: float) -> FloatArray:
        return np.array([4.0 * np.sin(20 * time) + 2.0 * np.sin(131 * time)])

    plain = run(FOUR_MASS, (), 600, waving)
    differences = [
        np.max(np.abs(run(FOUR_MASS, laws_of(FOUR_MASS, f"backlash@motor_1:gap={gap}"), 600, waving) - plain)[:, :4])
        for gap in (1e-4, 1e-6, 1e-8)
    ]
    assert differences[0] > 1e-5
    assert differences[1] < 2e-2 * differences[0]
    assert differences[2] < 1e-6


def test_it_gives_no_energy() -> None:
    start = np.array([2e-3, 0.0, 0.0, 0.0])
    path = run(TWO_MASS, laws_of(TWO_MASS, "backlash@motor_1:gap=1e-3"), 3000, still(TWO_MASS), start)
    twist = path[:, 1] - path[:, 0]
    twist = np.sign(twist) * np.maximum(np.abs(twist) - 0.5e-3, 0.0)
    energy = 3e4 * twist**2 + 3.0 * path[:, 2] ** 2 + 2.0 * path[:, 3] ** 2
    assert np.max(energy[1:]) <= energy[0]
    assert np.max(np.diff(energy)) < 2e-3 * energy[0]  # the twist that is left after a contact is not in it
    assert energy[-1] < 0.2 * energy[0]


def test_halving_the_step_converges() -> None:
    def waving(time: float) -> FloatArray:
        return np.array([3.0 * np.sin(20 * time)])

    law = laws_of(FOUR_MASS, "backlash@motor_1:gap=5e-3")
    errors = halving_errors(FOUR_MASS, law, 400, waving)
    effect = np.max(np.abs(run(FOUR_MASS, law, 400, waving) - run(FOUR_MASS, (), 400, waving))[:, :4])
    assert errors[0] < 0.02 * effect
    assert errors[3] < 0.3 * errors[0]


def test_gap_of_zero_switches_it_off_and_rigid_gears_have_none() -> None:
    assert PlantModel(TWO_MASS, laws_of(TWO_MASS, "backlash@motor_1:gap=0")).laws == ()
    assert Backlash().locations(load_robot("emps")) == ()
    assert Backlash().locations(load_robot("e12")) == ("motor_1", "motor_2")
