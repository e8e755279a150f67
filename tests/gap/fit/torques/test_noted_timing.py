"""When noted torques acted, by a fit of the log."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.fit.torques import noted_timing
from flexros.gap.fit.torques.noted_timing import shift_of_noted
from flexros.gap.measure_gap import measure_gap
from flexros.record.record import Record
from flexros.record.torques.shifted_torque import HELD
from tests.gap.diagnosis_logs import MODEL, record_of
from tests.gap.rigid_arm import INERTIA, VISCOUS, T, arm, motion

if TYPE_CHECKING:
    from collections.abc import Mapping

N = 1000
"""Prediction errors that count: a parameter costs ln N = 6.9."""
FAR, NEAR = 5000.0, 1000.0
"""Sums of squares that the hypothesis leaves of the log as it was noted: far from the floor, and near it."""
NOISE = 1e-5
"""Noise of the encoders [rad]."""
DELAY, FRICTION = "delay@all", "viscous_friction@motor_1"


def shift(
    monkeypatch: pytest.MonkeyPatch,
    left: Mapping[float, float],
    *,
    usual: float = FAR,
    delayed: bool = False,
    without_friction: float | None = None,
    in_one_part: bool = False,
    **recorded: Any,
) -> float | None:
    """Return the shift of a hypothesis that leaves more or less of torques that act earlier or later."""
    record = record_of()
    as_measured = {"measured_torque": True, "torque_shift": 0.0}
    record = replace(record, **{"noted": record.torque, "imported": True, **as_measured, **recorded})
    names = [FRICTION, *([DELAY] if delayed else [])]

    share = np.full(N, 1 / N)
    if in_one_part:
        share = np.zeros(N)
        share[0] = 1.0

    def fit(chosen: list[str], chi2: float) -> Any:
        effects = [
            SimpleNamespace(
                name=name, effect=SimpleNamespace(delays_commands=name == DELAY), free=(0,), neutral=lambda free: 0.0
            )
            for name in chosen
        ]
        rise = 0.0 if without_friction is None else without_friction - chi2
        return SimpleNamespace(
            hypothesis=tuple(effects),
            columns=lambda of: np.array([name in of for name in chosen]),
            theta=np.ones(len(chosen)),
            predictor=chosen,
            chi2=chi2,
            residual=lambda data: np.sqrt(chi2 * share),
            information=np.zeros((0, 0)) if without_friction is None else rise * np.eye(len(chosen)),
        )

    def fitted(predictor: list[str], moved: _Data, *_: Any, **__: Any) -> Any:
        at = moved.record.torque_shift
        if FRICTION not in predictor:
            return fit(predictor, without_friction)
        return fit(predictor, usual if at == record.torque_shift else left[at])

    data = _Data(record)
    null: Any = SimpleNamespace(data=data, model=MODEL, predictor=lambda chosen: [one.name for one in chosen])
    monkeypatch.setattr(noted_timing, "fit", fitted)
    monkeypatch.setattr(noted_timing, "_moved", lambda data, shift: _Data(replace(record, torque_shift=shift)))
    return shift_of_noted(fit(names, usual), null)


class _Data:
    """What the timing needs of a log."""

    negligible, n_values = 0.0, N
    squares_in_time = staticmethod(
        lambda residual, parts: np.array([part.sum() for part in np.split(residual[:992] ** 2, parts)])
    )

    def __init__(self, record: Any) -> None:
        self.record = record


@pytest.mark.parametrize(
    ("left", "expected"),
    [
        ({-0.5: 2000.0, 0.5: 9000.0, -1.0: 3000.0}, -0.5),
        ({-0.5: 9000.0, 0.5: 2000.0, 1.0: 3000.0}, 0.5),
        ({-0.5: 9000.0, 0.5: 3000.0, 1.0: 4000.0}, None),
        ({-0.5: 9000.0, 0.5: 2000.0, 1.0: 1000.0}, None),
    ],
    ids=["before", "after", "not clear", "rather a delay"],
)
def test_far_from_the_floor_torques_act_elsewhere_where_that_leaves_clearly_less(
    monkeypatch: pytest.MonkeyPatch, left: dict[float, float], expected: float | None
) -> None:
    assert shift(monkeypatch, left) == expected


@pytest.mark.parametrize(("least", "expected"), [(986.0, 0.5), (988.0, None)])
def test_near_the_floor_the_likelihood_tells(
    monkeypatch: pytest.MonkeyPatch, least: float, expected: float | None
) -> None:
    """ln 1000 + 6 = 12.9 = 1000 ln(1000 / 987.2)."""
    assert shift(monkeypatch, {-0.5: 1100.0, 0.5: least, 1.0: 1010.0}, usual=NEAR) == expected


def test_near_the_floor_the_parts_of_a_log_must_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    left = {-0.5: 1100.0, 0.5: 900.0, 1.0: 1010.0}
    assert shift(monkeypatch, left, usual=NEAR) == 0.5
    assert shift(monkeypatch, left, usual=NEAR, in_one_part=True) is None


@pytest.mark.parametrize(("least", "expected"), [(993.0, 0.0), (995.0, None)])
def test_an_effect_may_stand_for_half_a_sample(
    monkeypatch: pytest.MonkeyPatch, least: float, expected: float | None
) -> None:
    """Without it one parameter less counts, 6.9 of the 12.9."""
    commands = {"measured_torque": False, "torque_shift": 0.5}
    left = {0.0: 992.0, -0.5: 1050.0}
    assert shift(monkeypatch, left, usual=NEAR, without_friction=least, **commands) == expected


def test_commands_act_earlier_than_held_ones_and_never_later(monkeypatch: pytest.MonkeyPatch) -> None:
    commands = {"measured_torque": False, "torque_shift": 0.5}
    assert shift(monkeypatch, {0.0: 900.0, -0.5: 950.0, 1.0: 100.0}, usual=NEAR, **commands) == 0.0
    assert shift(monkeypatch, {0.0: 950.0, -0.5: 900.0, -1.0: 950.0}, usual=NEAR, **commands) == -0.5
    assert shift(monkeypatch, {0.0: 100.0}, usual=NEAR, delayed=True, **commands) is None


@pytest.mark.parametrize(("least", "expected"), [(950.0, 0.5), (1050.0, None)])
def test_half_a_sample_comes_before_a_delay_that_does_no_better(
    monkeypatch: pytest.MonkeyPatch, least: float, expected: float | None
) -> None:
    assert shift(monkeypatch, {-0.5: 9000.0, 0.5: least, 1.0: 3000.0}, usual=NEAR, delayed=True) == expected


@pytest.mark.parametrize("recorded", [{"torque_shift": 0.5}, {"imported": False}, {"noted": None}])
def test_timing_that_is_known_is_not_sought(monkeypatch: pytest.MonkeyPatch, recorded: dict[str, Any]) -> None:
    assert shift(monkeypatch, {}, **recorded) is None


def model() -> RobotWithEffects:
    """Return the model of the arm with its rotors and viscous friction."""
    numbers = {"inertia": INERTIA, "viscous_friction": VISCOUS}
    return RobotWithEffects(
        arm().with_values({f"motor_{1 + i}.{name}": sizes[i] for name, sizes in numbers.items() for i in range(2)}), ()
    )


def log(*, thinned: bool) -> Record:
    """Return a log of the arm, with commands as they are at their stamps, or as they are held from there on."""
    q, v, a = motion()
    plant = arm().model
    torque = np.asarray(plant.arm_inverse_dynamics(q.T, v.T, a.T, plant.parameter_values), dtype=float).T
    torque += INERTIA * a + VISCOUS * v
    held = 0.5 * (torque + np.vstack([torque[1:], torque[-1:]]))
    noted = torque if thinned else held
    position = q + NOISE * np.random.default_rng(3).standard_normal(q.shape)
    return Record("log", T, position, noted, np.ones(len(q), dtype=bool), noted=noted, torque_shift=HELD, imported=True)


@pytest.mark.slow
@pytest.mark.parametrize("thinned", [True, False])
def test_thinned_commands_act_at_their_stamps_and_held_ones_behind_them(thinned: bool) -> None:
    found = measure_gap(log(thinned=thinned), model(), tolerance={"torque": 0.005})
    assert any("as values at their stamps" in text for text in found.warnings) == thinned
    assert not found.significant
