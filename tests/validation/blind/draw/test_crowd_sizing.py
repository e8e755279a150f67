"""What an effect of a crowd is worth when it is added last."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.draw.case_setting import Setting
from flexros.validation.blind.draw.crowd_sizing import LEAST, CrowdRehearsal, size_crowd
from flexros.validation.blind.draw.draw import Draft
from flexros.validation.blind.draw.nominal_filter import NominalFilter
from flexros.validation.blind.draw.sizing import Rehearsal
from flexros.validation.blind.plant.plant import UnstableCaseError

pytestmark = pytest.mark.slow

FRICTION = {"level": 0.1, "asymmetry": 0.0}


def hidden(effect: str, **parameters: float) -> Deviation:
    return Deviation(effect=effect, location="motor_1", parameters=parameters)


@pytest.fixture(scope="module")
def rehearsal() -> Rehearsal:
    setting = Setting.draw("four_mass_linear", np.random.default_rng(4))
    reference = setting.reference(4.0, np.random.default_rng(5))
    return Rehearsal(setting, reference, NominalFilter(setting.robot, setting.sample_time))


def test_two_effects_are_worth_together_what_they_are_worth_alone_where_they_do_not_overlap(
    rehearsal: Rehearsal,
) -> None:
    bias, quick = hidden("torque_bias", level=0.02), hidden("delay", time=2e-4)
    together = CrowdRehearsal(rehearsal).gains([bias, quick])
    alone = [rehearsal.gain(one) for one in (bias, quick)]
    assert together == pytest.approx(alone, rel=0.2)


def test_what_another_effect_can_imitate_is_worth_little(rehearsal: Rehearsal) -> None:
    quick = [hidden("delay", time=1e-4), hidden("actuator_lag", time_constant=1e-4)]
    alone = [rehearsal.gain(one) for one in quick]
    last = CrowdRehearsal(rehearsal).gains(quick)
    assert max(last) < 0.1 * min(alone)


def test_a_plant_with_all_effects_follows_the_run_without_error(rehearsal: Rehearsal) -> None:
    crowd = [hidden("coulomb_friction", **FRICTION), hidden("torque_bias", level=0.05)]
    run = rehearsal.run(crowd)
    followed = CrowdRehearsal(rehearsal)._innovations(run, crowd, rehearsal.setting.robot.encoder_noise)
    missed = CrowdRehearsal(rehearsal)._innovations(run, crowd[:1], rehearsal.setting.robot.encoder_noise)
    assert followed @ followed < 1e-3 * (missed @ missed)


def test_sizes_are_raised_until_every_effect_is_worth_the_least(rehearsal: Rehearsal) -> None:
    drafts = [
        Draft("torque_bias", "motor_1", lambda s: {"level": 1e-4 * s}, 1e4),
        Draft("viscous_friction", "motor_1", lambda s: {"coefficient": 1e-5 * s, "asymmetry": 0.0}, 1e4),
        Draft("delay", "motor_1", lambda s: {"time": 1e-6 * s}, 1e3),
    ]
    crowd = size_crowd(drafts, [60.0, 60.0, 60.0], rehearsal)
    assert len(crowd) == 3
    assert min(one.gain for one in crowd) >= LEAST


def test_a_crowd_of_which_too_little_shows_is_drawn_anew(rehearsal: Rehearsal) -> None:
    drafts = [Draft("torque_bias", "motor_1", lambda s: {"level": 1e-9 * s}, 1.0)] * 3
    with pytest.raises(UnstableCaseError, match="too few effects"):
        size_crowd(drafts[:1], [100.0], rehearsal)
