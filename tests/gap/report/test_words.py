"""Words for effects, locations and parameters."""

from __future__ import annotations

import pytest

from flexros.gap.report.words import (
    cause_words,
    causes_words,
    effect_words,
    first_few,
    listed,
    location_words,
    parameter_words,
    undetermined_words,
    where_words,
)
from flexros.gap.schema import Cause, CauseParameter, Excess


def parameter(value: float, std: float, unit: str) -> CauseParameter:
    return CauseParameter(value=value, std=std, unit=unit)


def test_effects_are_named_in_words() -> None:
    assert effect_words("coulomb_friction") == "Coulomb friction"
    assert effect_words("torque_gain_error") == "torque gain error"
    assert effect_words("friction_curve") == "friction of unknown law"


def test_of_a_curve_its_smallest_and_largest_torque_are_written() -> None:
    """Sizes that it shares with a law beside it are zero, and not among its parameters."""
    torques = {f"torque_{k}": parameter(0.1 * k - 0.25, 0.01, "Nm") for k in range(1, 9)}
    curve = Cause(effect="torque_curve", location="motor_1", probability=1.0, parameters=torques, closed_fraction=None)
    assert cause_words(curve) == "torque over position of unknown law at motor_1, -0.150 to 0.550 Nm (±0.010)"
    shared = {name: one for name, one in torques.items() if one.value > 0.1}
    assert cause_words(curve.model_copy(update={"parameters": shared})).endswith(", 0 to 0.550 Nm (±0.010)")


@pytest.mark.parametrize(("x", "before"), [(-0.67, "what acts like "), (0.02, "")])
def test_a_cause_of_a_size_that_it_hardly_ever_has_is_not_stated_as_certain(x: float, before: str) -> None:
    """A tether had been a tilt of 46 deg."""
    angles = {"x": parameter(x, 0.001, "rad"), "y": parameter(0.045, 0.001, "rad")}
    tilt = Cause(effect="base_tilt", location="base", probability=1.0, parameters=angles, closed_fraction=None)
    assert cause_words(tilt).startswith(f"{before}tilt at the base, x ")
    others = [tilt.model_copy(update={"effect": "torque_bias", "location": f"motor_{k}"}) for k in range(1, 5)]
    assert f"5 effects: {before}tilt at the base and " in causes_words([tilt, *others])


def test_locations_are_named_in_words() -> None:
    assert location_words("motor_1") == "at motor_1"
    assert location_words("body_1.rz") == "in spring body_1.rz"
    assert location_words("tool") == "at the tool"
    assert location_words("all") == "at all motors"


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("level", parameter(0.2134, 0.0113, "Nm"), "0.213 Nm (±0.011)"),
        ("gap", parameter(2.1e-4, 3e-6, "rad"), "0.2100 mrad (±0.0030)"),
        ("time", parameter(4.7e-4, 1e-5, "s"), "0.470 ms (±0.010)"),
        ("relative", parameter(-0.052, 0.003, "1"), "-5.20 % (±0.30)"),
        ("relative", parameter(0.052, 0.003, "1"), "+5.20 % (±0.30)"),
        ("frequency", parameter(11.3, 0.2, "Hz"), "11.30 Hz (±0.20)"),
        ("coefficient", parameter(203.0, 1.2, "N s/m"), "203.0 N s/m (±1.2)"),
        ("order", parameter(6.0, 0.0, "1"), "6"),
        ("asymmetry", parameter(0.05, 0.12, "1"), "0.05 (±0.12)"),
        ("level", parameter(0.0, 0.0, "Nm"), "0 Nm"),
        ("stiffness", parameter(2.5e6, 3e3, "Nm/rad"), "2500000 Nm/rad (±3000)"),
    ],
)
def test_a_number_has_the_digits_that_its_deviation_leaves(name: str, value: CauseParameter, text: str) -> None:
    assert parameter_words(name, value) == text


def test_a_number_below_its_deviation_is_not_determined() -> None:
    level = CauseParameter(value=35.0, std=216.0, unit="Nm", determined=False)
    assert parameter_words("level", level) == "not determined"


@pytest.mark.parametrize(
    ("effect", "numbers", "text"),
    [
        ("stiffness_error", {"relative": parameter(0.1, 0.2, "1")}, "not determined: between -30 and 50 %"),
        ("backlash", {"gap": parameter(0.0, 0.01, "rad")}, "not determined: between -20 and 20 mrad"),
        ("friction_curve", {"level_1": parameter(0.1, 0.2, "Nm")}, "not determined"),
        (
            "tool_load",
            {"mass": parameter(1.0, 2.0, "kg"), "x": parameter(0.1, 0.2, "m")},
            "not determined: mass between -3 and 5 kg",
        ),
    ],
)
def test_a_cause_without_a_size_has_the_ends_of_it(effect: str, numbers: dict[str, CauseParameter], text: str) -> None:
    cause = Cause(
        effect=effect, location="motor_1", probability=1.0, parameters=numbers, closed_fraction=None, determined=False
    )
    (said,) = undetermined_words([cause])
    assert said.endswith(f": present, size {text}")


def test_an_unlikely_effect_is_not_said_to_be_present() -> None:
    cause = Cause(
        effect="backlash",
        location="motor_1",
        probability=0.1,
        parameters={"gap": parameter(0.0, 0.01, "rad")},
        closed_fraction=None,
        determined=False,
    )
    assert undetermined_words([cause]) == ()


def test_a_number_that_may_be_zero_is_left_out_of_the_cause() -> None:
    numbers = {"level": parameter(0.2134, 0.0113, "Nm"), "asymmetry": parameter(0.05, 0.12, "1")}
    cause = Cause(
        effect="coulomb_friction", location="motor_1", probability=1.0, parameters=numbers, closed_fraction=None
    )
    assert cause_words(cause) == "Coulomb friction at motor_1, 0.213 Nm (±0.011)"


def test_places_of_the_gap() -> None:
    place = Excess(signal="position", joint="motor_1", band_hz=(0.0, 8.0), regime="low speed", share=0.5, p_value=0.01)
    assert where_words(place) == "motor_1, below 8 Hz, at low speed: 50 % of the excess"


def test_lists_read_as_sentences() -> None:
    assert [listed(texts) for texts in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["", "a", "a and b", "a, b and c"]


def test_long_lists_are_counted() -> None:
    assert first_few(["a", "b", "c"], "from") == "a, b from c"
    assert first_few(["a", "b", "c", "d"], "from") == "a, b, c from 1 other"
    assert first_few(["a", "b", "c", "d", "e"], "or") == "a, b, c or 2 others"


@pytest.mark.parametrize(
    ("band", "regime", "words"),
    [
        ((0.0, 4.0), "reversal", "motor_2, below 4 Hz, at reversals: 63 % of the excess"),
        ((0.0, 1000.0), "all", "motor_2: 63 % of the excess"),
        ((125.0, 1000.0), "high torque", "motor_2, above 125 Hz, under high torque: 63 % of the excess"),
        ((4.0, 8.0), "motor angle order 6.00", "motor_2, 4 to 8 Hz, at motor angle order 6.00: 63 % of the excess"),
    ],
)
def test_location_of_the_excess(band: tuple[float, float], regime: str, words: str) -> None:
    location = Excess(signal="position", joint="motor_2", band_hz=band, regime=regime, share=0.63, p_value=0.01)
    assert where_words(location, 5e-4) == words


def test_innovations_are_called_sudden_changes() -> None:
    location = Excess(
        signal="sudden position change", joint="motor_1", band_hz=(0, 1000), regime="reversal", share=0.5, p_value=0.01
    )
    assert where_words(location, 5e-4) == "motor_1, at reversals: 50 % of the sudden changes"


def test_lines_of_a_multisine_are_named() -> None:
    location = Excess(
        signal="odd detection lines", joint="motor_1", band_hz=(1, 30), regime="multisine 2", share=0.5, p_value=0.01
    )
    words = "motor_1, 1 to 30 Hz, at multisine 2: 50 % of the excess of the multisines, at odd detection lines"
    assert where_words(location, 5e-4) == words


def test_many_causes_are_gathered_by_effect() -> None:
    level = {"level": CauseParameter(value=0.2, std=0.01, unit="Nm")}
    places = [("coulomb_friction", f"motor_{k}") for k in (1, 2, 4)] + [("delay", "all"), ("payload_error", "tool")]
    causes = [
        Cause(effect=effect, location=at, probability=1.0, parameters=level, closed_fraction=None)
        for effect, at in places
    ]
    assert causes_words(causes) == (
        "5 effects: Coulomb friction (motor_1, motor_2 and motor_4), delay at all motors and payload error at the tool"
    )
    assert causes_words(causes[:1]) == "Coulomb friction at motor_1, 0.200 Nm (±0.010)"


def test_of_many_causes_the_largest_are_named() -> None:
    causes = [
        Cause(effect="torque_bias", location=f"motor_{k}", probability=1.0, parameters={}, closed_fraction=None)
        for k in range(1, 8)
    ]
    assert causes_words(causes) == (
        "7 effects, the largest ones torque bias at motor_1, torque bias at motor_2 and torque bias at motor_3"
    )
