"""Write effects.md from the effects themselves, with its pictures: python docs/generate/effects_page.py [FOLDER]."""

from __future__ import annotations

import inspect
import re
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from effects_pictures import DRAWINGS, pictures

from flexros.effects.kinds.base import AbstractEffect, Stage, effects
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.robot import load_robot

if TYPE_CHECKING:
    from flexros.effects.kinds.ranges import Range

UNITS = {"relative": "", "time": " s", "frequency": " Hz", "order": " per turn", "phase": " rad"}
"""Units of bounds that are multiples of nothing in a log."""
ALONE, ROBOT = 0.1, "six_axis"
"""Size of a parameter alone, and built-in robot that has a location for every effect of several parameters."""
HEAD = """# Effects

Every deviation of a real robot from its ideal model is one file in `flexros/effects`. The same effects make a simulated
robot real and are the hypotheses of a gap diagnosis. Any number of them can be combined at any locations:

<!-- run by tests/contracts/test_guide.py with ROS 2 -->
```
flexros run circle_dae --effect coulomb_friction@motor_1:level=20 --effect extra_mode@base:frequency=9,ratio=0.5
```

and in a scenario, a patch or Python

```python
from flexros.effects import parse_effect, place_effects
from flexros.robot import load_robot

placed = place_effects(load_robot("e12"), [parse_effect("backlash@motor_1:gap=1e-4", "my script")])
print(placed.robot.name, [law.name for law in placed.laws])  # the changed robot, and the remaining laws
```

All numbers are SI, on the side of the gear on which the robot file states its own. A spring is named by its direction
(`body_3.ry`), a gear by its motor (`motor_2`). "Switched off by" is the neutral value; "searched" is where a diagnosis
looks for the number, as a multiple of the largest size in the log where it says so.

Laws of one spring act one on what the other has made of it, from the motor to the arm: transmission error, knee of the
spring, backlash, hysteresis. So a gap counts from the shifted deflection, and hysteresis turns with the shaft and not
with the gap. Errors of parameters change the robot, and with it the motion that the laws act on.

This page is written from the classes by `docs/generate/effects_page.py`. The pictures are runs and linearisations of
built-in robots with the parameters given below each.
"""


def page() -> str:
    """Write the page.

    Returns:
        Its text in Markdown.
    """
    parts = [HEAD, _contents()]
    for stage in get_args(Stage):
        found = [kind for kind in effects().values() if kind.stage == stage]
        if found:
            parts.append(f"## {stage[0].upper()}{stage[1:]}\n")
            parts += [_section(kind) for kind in found]
    return "\n".join(parts)


def _contents() -> str:
    rows = ["| stage | effects |", "|---|---|"]
    for stage in get_args(Stage):
        names = [name for name, kind in effects().items() if kind.stage == stage]
        if names:
            rows.append(f"| {stage} | {', '.join(f'[{name}](#{name})' for name in names)} |")
    return "\n".join([*rows, ""])


def _section(kind: type[AbstractEffect]) -> str:
    text = inspect.getdoc(kind) or ""
    locations = (inspect.getdoc(kind.locations) or "").partition("\n")[0]
    locations = re.sub(r"^(List|Return) ", "", locations).rstrip(".")
    example = DRAWINGS[kind.name][1]
    shown = example if "@" in example else f"{kind.name}@...:{example}"
    return "\n".join(
        [
            f"### {kind.name}\n",
            f"{text}\n",
            f"Locations: {locations}.\n",
            _table(kind),
            *([f"A diagnosis seeks it only {kind.sought_where}.\n"] if kind.sought_where else []),
            textwrap.fill(f"Seen in data: {kind.fingerprint}.", 120, break_on_hyphens=False) + "\n",
            f"![{kind.name}](pictures/effects/{kind.name}.svg)\n",
            f"`{shown}`\n",
        ]
    )


def _table(kind: type[AbstractEffect]) -> str:
    rows = ["| parameter | meaning | default | searched | source of the range |", "|---|---|---|---|---|"]
    for name, field in kind.model_fields.items():
        allowed = kind.ranges.get(name)
        where, source = (_searched(allowed), allowed.source) if allowed else ("not fitted", "")
        rows.append(f"| `{name}` | {field.description} | {_number(field.default)} | {where} | {source} |")
    sizes = " and ".join(f"`{name}` = 0" for name in _sizes(kind))
    return "\n".join([*rows, "", f"Switched off by {sizes}.\n"])


def _sizes(kind: type[AbstractEffect]) -> list[str]:
    """List the parameters that switch an effect on."""
    names = [name for name, field in kind.model_fields.items() if field.annotation is float]
    if len(names) == 1:
        return names
    single: list[dict[str, Any]] = [{name: ALONE} for name in names]
    return [name for name, values in zip(names, single) if _acts(kind.model_construct(**values))]


def _acts(effect: AbstractEffect) -> bool:
    """Whether an effect is not switched off."""
    if isinstance(effect, AbstractLaw):
        return not effect.neutral
    assert isinstance(effect, AbstractChangedValues)
    robot = load_robot(ROBOT)
    changed = effect.values(robot, effect.locations(robot)[0])
    return any(value != robot.parameters[name].value for name, value in changed.items())


def _searched(allowed: Range) -> str:
    sign = "either sign, " if allowed.signed else ""
    unit = UNITS.get(allowed.scale, f" times the largest {allowed.scale}")
    below = "" if allowed.negative is None else f", negative to {allowed.negative:g}"
    return f"{sign}{allowed.low:g} to {allowed.high:g}{unit}{below}"


def _number(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).lower()


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "reference"
    (folder / "pictures" / "effects").mkdir(parents=True, exist_ok=True)
    (folder / "effects.md").write_text(page(), encoding="utf-8")
    for name, text in pictures().items():
        (folder / "pictures" / "effects" / f"{name}.svg").write_text(text, encoding="utf-8")
