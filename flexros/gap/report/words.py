"""Names of effects, locations and parameters, and lists of causes, in sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from flexros.effects import effects
from flexros.effects.kinds.curve import AbstractCurve
from flexros.gap.report.figure_words import SCALED, scaled, with_std
from flexros.gap.where.base import views
from flexros.gap.where.regimes import REGIMES
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.gap.result import RankedCandidate
    from flexros.gap.schema import BudgetShare, Cause, CauseParameter, EffectLocation, Excess, ModelNumber

_PROPER = {"coulomb": "Coulomb", "stribeck": "Stribeck"}
_CLEAR = 2.0
"""Standard deviations from zero from which parameters other than the first are stated in a sentence (chosen)."""
LIKELY = 0.5
"""Probability from which an effect is reported as part of the truth (chosen)."""
UNKNOWN_RATE = 1e-12
"""Sample time [s] that means not known: no band then reaches the Nyquist frequency."""
NOT_DETERMINED = "not determined"
"""A number whose standard deviation is above its size."""
_MOST_CAUSES, _MOST_GATHERED, _MOST_PARTNERS = 4, 6, 3
"""Causes that a sentence states with their sizes, and with all their locations, and effects that are named beside
another one (chosen)."""
_LARGEST = 3
"""Causes that a sentence names of more than it states (chosen)."""


def effect_words(effect: str) -> str:
    """Write the name of an effect as words, e.g. "Coulomb friction", "torque gain error", "friction of unknown law".

    Args:
        effect: Name of the effect, e.g. "coulomb_friction".
    """
    kind = effects().get(effect)
    if kind is not None and kind.words:
        return kind.words
    return " ".join(_PROPER.get(word, word) for word in effect.split("_"))


def location_words(location: str) -> str:
    """Write a location as words, e.g. "at motor_1", "in spring body_1.rz", "at the tool", "at all motors".

    Args:
        location: Joint, spring, body, "tool", "base" or "all".
    """
    if location in ("tool", "base"):
        return f"at the {location}"
    if location == "all":
        return "at all motors"
    return f"in spring {location}" if "." in location else f"at {location}"


def named(effect: EffectLocation | RankedCandidate) -> str:
    """Write an effect with its location, e.g. "Coulomb friction at motor_1"."""
    return f"{effect_words(effect.effect)} {location_words(effect.location)}"


def named_at(joint: str, effect: str, location: str) -> str:
    """Write an effect below the heading of a joint: with its location where that is another one.

    Args:
        joint: The joint.
        effect: Name of the effect.
        location: Its location.
    """
    return effect_words(effect) if location == joint else f"{effect_words(effect)} {location_words(location)}"


def budget_words(share: BudgetShare) -> str:
    """Write whose share of the gap it is, e.g. "Coulomb friction at motor_1", "all friction at motor_1"."""
    if share.effect is None:
        return f"all {share.cause_class} {location_words(share.location)}"
    return f"{effect_words(share.effect)} {location_words(share.location)}"


def capital(text: str) -> str:
    """Write a text with its first letter as a capital."""
    return text[:1].upper() + text[1:]


def listed(texts: Sequence[str], last: str = "and") -> str:
    """Join texts as in a sentence: "a", "a and b", "a, b and c".

    Args:
        texts: The texts.
        last: Word before the last of them.
    """
    if len(texts) < 2:
        return "".join(texts)
    return f"{', '.join(texts[:-1])} {last} {texts[-1]}"


def first_few(texts: Sequence[str], last: str = "and", most: int = 3) -> str:
    """Join texts as `listed` does, and count those after the first few: "a, b, c and 2 others".

    Args:
        texts: The texts.
        last: Word before the last of them.
        most: Texts that are written.
    """
    more = len(texts) - most
    return listed([*texts[:most], f"{more} other{'s' * (more > 1)}"] if more > 0 else texts, last)


def parameter_words(name: str, parameter: CauseParameter) -> str:
    """Write the value of a parameter with its standard deviation, e.g. "0.21 Nm (±0.01)", "+5.2 % (±0.3)".

    One whose deviation is above its size is "not determined".

    Args:
        name: Name of the parameter; one called "relative" is written in per cent.
        parameter: The fitted parameter.
    """
    if not parameter.determined:
        return NOT_DETERMINED
    value, std, unit = parameter.value, parameter.std, parameter.unit
    if unit == "1" and name == "relative":
        return f"{'+' if value > 0 else ''}{with_std(100 * value, 100 * std, '%')}"
    if unit in SCALED:
        scale, prefixed = scaled(max(abs(value), std) if math.isfinite(std) else abs(value), unit)
        return with_std(value / scale, std / scale, prefixed) if value else f"0 {unit}"
    return with_std(value, std, "" if unit == "1" else unit)


def number_words(one: ModelNumber, *, unit: bool = True) -> str:
    """Write the fitted value of a number, e.g. "0.81 kg m2 (±0.02)", "151.5 kg or beyond (limit of its search)".

    Args:
        one: The number.
        unit: Whether its unit is written.
    """
    own = one.unit if unit else ""
    if one.at_limit:
        return f"{number(one.value, 4)} {own}".rstrip() + " or beyond (limit of its search)"
    return with_std(one.value, one.std, own) if one.determined else NOT_DETERMINED


def parameters_words(parameters: Mapping[str, CauseParameter]) -> str:
    """Write parameters: a single one without its name, several with their names.

    Returns:
        E.g. "0.21 Nm (±0.01)" or "amplitude 0.2 Nm (±0.01), order 6.001 (±0.002)"; empty for none.
    """
    if len(parameters) == 1:
        return "".join(parameter_words(name, parameter) for name, parameter in parameters.items())
    return ", ".join(
        f"{name.replace('_', ' ')} {parameter_words(name, parameter)}" for name, parameter in parameters.items()
    )


def cause_words(cause: Cause | RankedCandidate) -> str:
    """Write an effect with location and clear parameters, e.g. "Coulomb friction at motor_1, 0.213 Nm (±0.011)"."""
    parameters = clear_words(cause.effect, cause.parameters)
    return f"{_imitated(cause)}{named(cause)}{', ' if parameters else ''}{parameters}"


def _imitated(cause: Cause | RankedCandidate) -> str:
    """Return words before the name of an effect of a size that it hardly ever has; empty for a usual one."""
    kind, values = effects().get(cause.effect), {name: one.value for name, one in cause.parameters.items()}
    return "what acts like " if kind is not None and kind.model_construct(None, **values).stands_for() else ""


def undetermined_words(causes: Sequence[Cause]) -> tuple[str, ...]:
    """Say of every likely cause whose size the log does not determine that its probability is none of a size.

    Returns:
        E.g. "Coulomb friction at motor_1: present, size not determined: between -0.31 and 0.52 Nm"; the ends are two
        standard deviations away. Of several sizes the first is written, of a curve none.
    """
    return tuple(_without_size(cause) for cause in causes if not cause.determined and cause.probability >= LIKELY)


def _without_size(cause: Cause) -> str:
    words, kind = f"{capital(named(cause))}: present, size {NOT_DETERMINED}", effects().get(cause.effect)
    name, size = next(iter(cause.parameters.items()), ("", None))
    if size is None or (kind is not None and issubclass(kind, AbstractCurve)):
        return words
    factor, unit = (100.0, "%") if size.unit == "1" and name == "relative" else (1.0, size.unit)
    low, high = (factor * (size.value + side * size.std) for side in (-2, 2))
    scale, unit = scaled(max(abs(low), abs(high)), unit)
    label = f"{name.replace('_', ' ')} " if len(cause.parameters) > 1 else ""
    return f"{words}: {label}between {number(low / scale, 2)} and {number(high / scale, 2)} {unit}".removesuffix(" 1")


def causes_words(causes: Sequence[Cause]) -> str:
    """Write what a gap comes from: a few causes with their sizes, more of them gathered by effect, of many the largest.

    Args:
        causes: The causes, the largest first.

    Returns:
        E.g. "Coulomb friction at motor_1, 0.213 Nm (±0.011) and delay at all motors, 2.1 ms (±0.1)", "5 effects:
        Coulomb friction (motor_1, motor_2 and motor_4) and viscous friction (motor_1 and motor_2)", or "13 effects, the
        largest ones delay at all motors, tool load at the tool and Coulomb friction at motor_1".
    """
    if len(causes) <= _MOST_CAUSES:
        return listed([cause_words(cause) for cause in causes])
    if len(causes) > _MOST_GATHERED:
        largest = listed([f"{_imitated(cause)}{named(cause)}" for cause in causes[:_LARGEST]])
        return f"{len(causes)} effects, the largest ones {largest}"
    places: dict[str, list[str]] = {}
    for cause in causes:
        places.setdefault(f"{_imitated(cause)}{effect_words(cause.effect)}", []).append(cause.location)
    gathered = [
        f"{words} ({listed(at)})" if len(at) > 1 else f"{words} {location_words(at[0])}" for words, at in places.items()
    ]
    return f"{len(causes)} effects: {listed(gathered)}"


def partners_words(candidate: RankedCandidate) -> str:
    """Write what an effect explains the log together with: a few by name, more as their number; empty for none."""
    partners = candidate.together_with
    if len(partners) > _MOST_PARTNERS:
        return f"the {len(partners)} other effects of its explanation"
    return listed([named(location) for location in partners])


def clear_words(effect: str, parameters: Mapping[str, CauseParameter]) -> str:
    """Write the first parameter, and further ones that are clearly different from zero; of a curve from where to where.

    Args:
        effect: Name of the effect.
        parameters: Its fitted parameters.
    """
    kind = effects().get(effect)
    if kind is not None and issubclass(kind, AbstractCurve):
        return _extent_words(kind, parameters)
    return parameters_words(
        {
            name: parameter
            for index, (name, parameter) in enumerate(parameters.items())
            if index == 0 or abs(parameter.value) > _CLEAR * parameter.std
        }
    )


def _extent_words(curve: type[AbstractCurve], parameters: Mapping[str, CauseParameter]) -> str:
    """Write the smallest and largest value of a curve, and its largest deviation, e.g. "-7.54 to 15.6 Nm (±0.4)"."""
    known = [one for one in parameters.values() if one.determined]
    if not known:
        return NOT_DETERMINED
    values = [one.value for one in known] + [0.0] * (len(known) < len(curve.ranges))
    scale, unit = scaled(max(map(abs, values)), known[0].unit)
    ends = f"{number(min(values) / scale, 3)} to {number(max(values) / scale, 3)} {unit}"
    return f"{ends} (±{number(max(one.std for one in known) / scale, 2)})"


def where_words(location: Excess, sample_time: float = UNKNOWN_RATE) -> str:
    """Describe a location, e.g. "motor_2, below 4 Hz, at reversals: 63 % of the excess".

    Args:
        location: The location.
        sample_time: Sample time of the log [s], default: not known; a band up to the Nyquist frequency is written
            "above ... Hz".
    """
    low, high = location.band_hz
    top = high >= 0.99 * 0.5 / sample_time
    band = "" if low <= 0 and top else f"below {high:.3g} Hz" if low <= 0 else f"{low:.3g} to {high:.3g} Hz"
    if top and low > 0:
        band = f"above {low:.3g} Hz"
    regime = REGIMES[location.regime].phrase if location.regime in REGIMES else f"at {location.regime}"
    words = {signal: text for view in views() for signal, text in view.words.items()}
    where = ", ".join(part for part in (location.joint, band, regime) if part)
    return f"{where}: {100 * location.share:.0f} % of the {words.get(location.signal, 'excess')}"
