"""Write mujoco_robots.md: python docs/results/programs/simulated/mujoco_robots.py.

Options: [--cases MODE:SEED[:URDF] ...] [--work FOLDER].

Each case leaves its row in mujoco_robots.json as soon as it is done; the page is written from that file. Cases that are
there are not computed again (`--again` does). The evaluation cases of the page are EVALUATION; development seeds are
below 1000, and those of earlier pages, 1001 to 1052, 6201 to 6261 and 7301 to 7352. A URDF is a file of your own, such
as one from a clone of a public repository of models; its meshes are not needed.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, get_args

from mujoco_robots_arms import Arm, Drive, arm_of_urdf, drawn_arm
from mujoco_robots_page import page
from mujoco_robots_truth import DURATION, Mode, Truth, drawn_truth, run, write_log

from flexros.effects import effects
from flexros.effects.kinds.base import PlacedEffect
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.patching.patched_robot import load_model, load_patched
from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.measure_gap import measure_gap
from flexros.gap.report.files import write_diagnosis
from flexros.gap.settings import DiagnosisSettings
from flexros.json_text import json_text
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.provenance import code_version

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.schema import Diagnosis
    from flexros.record.record import Record

UR5E = Path(__file__).parents[3] / "examples" / "ur5e.urdf"
EVALUATION = (
    *(f"torque:{seed}" for seed in range(7601, 7608)),
    *(f"delay:{seed}" for seed in range(7611, 7616)),
    *(f"elastic:{seed}" for seed in range(7621, 7625)),
    *(f"backlash:{seed}" for seed in range(7631, 7635)),
    *(f"servo:{seed}" for seed in range(7641, 7647)),
    *(f"{mode}:{seed}:{UR5E.name}" for mode, seed in (("torque", 7651), ("delay", 7652))),
    *(f"many:{seed}:{UR5E.name}" for seed in (7661, 7662)),
)
"""Cases of the page; their seeds were not used before it."""
NAMES = ("fitted", "held", "other")
LIMIT = 150.0
"""Time after which a diagnosis is partial [s]."""


@dataclass(frozen=True)
class Case:
    """A case.

    Attributes:
        mode: What is tried.
        seed: Seed of arm, truth and logs.
        urdf: URDF of the arm; None for a drawn one.
    """

    mode: Mode
    seed: int
    urdf: Path | None = None

    @staticmethod
    def named(text: str) -> Case:
        """Read a case as written on the command line."""
        mode, seed, urdf = [*text.split(":", 2), ""][:3]
        if mode not in get_args(Mode) or not seed.isdigit():
            raise InputError(f"a case is MODE:SEED[:URDF] with a mode of {', '.join(get_args(Mode))}, not '{text}'")
        return Case(mode, int(seed), (UR5E if urdf == UR5E.name else Path(urdf)) if urdf else None)  # type: ignore[arg-type]

    def prepared(self, folder: Path) -> tuple[Arm, Truth]:
        """Draw or import the arm and draw what it hides."""
        if self.urdf is not None:
            arm = arm_of_urdf(self.urdf, folder)
        else:
            drive: Drive = "servo" if self.mode == "servo" else "torque"
            arm = drawn_arm(self.seed, folder, drive=drive, elastic=self.mode in ("elastic", "backlash"))
        return arm, drawn_truth(arm, self.mode, self.seed)


def expected(truth: Truth, model: RobotWithEffects) -> dict[str, float]:
    """Return the size of every hidden effect by its name and location, as a diagnosis names them."""
    springs = {motor.name: motor.joint.name for motor in model.robot.motors}
    found = {}
    for (effect, motor), size in truth.causes.items():
        found[f"{effect}@{springs[motor] if effect == 'stiffness_error' else motor}"] = size
    found |= {f"rotor_inertia@{motor}": size for motor, size in truth.rotors.items()}
    if truth.late:
        found["delay@all"] = truth.late
    return found


def visible(record: Record, model: RobotWithEffects, hidden: dict[str, float]) -> dict[str, bool]:
    """Return whether the log shows each effect: a model with all others leaves more than noise and its tolerance.

    A load and rotor inertias are estimated by every gap, as numbers that the model lacks, and count as shown.
    """
    placed = {}
    for name, size in hidden.items():
        effect, location = name.split("@")
        if effect == "rotor_inertia":
            placed[name] = PlacedEffect(RotorInertia(added=size), location)
        elif effect != "tool_load":
            kind = effects()[effect]
            placed[name] = PlacedEffect(kind(**{next(iter(kind.model_fields)): size}), location)
    shown = {}
    for name in hidden:
        others = [one for other, one in placed.items() if other != name]
        estimated = name.startswith(("tool_load", "rotor_inertia"))
        shown[name] = estimated or measure_gap(record, model.with_effects(others)).significant
    return shown


def named(diagnosis: Diagnosis) -> dict[str, tuple[float, float]]:
    """Return size and standard deviation of every effect that is named, and of the numbers that the model lacks."""
    found = {}
    for cause in diagnosis.causes:
        parameters = list(cause.parameters.values())
        if cause.probability > 0.5 and not any(one.at_limit for one in parameters):
            found[f"{cause.effect}@{cause.location}"] = parameters[0].value, parameters[0].std
    for number in diagnosis.model_numbers:
        if number.nominal == 0 and number.name.endswith(".inertia"):
            found[f"rotor_inertia@{number.location}"] = number.value, number.std
        if number.name == "tool_load.mass":
            found["tool_load@tool"] = number.value, number.std
    return found


def result_of(case: Case, folder: Path) -> dict[str, Any]:
    """Simulate and diagnose a case.

    Args:
        case: The case.
        folder: Empty folder for its files.
    """
    arm, truth = case.prepared(folder)
    model = load_model(arm.robot)
    records = []
    try:
        for k, name in enumerate(NAMES):
            mapping, table = write_log(arm, truth, run(arm, truth, 1000 * case.seed + k), folder, name)
            records.append(checked_log(import_log(load_mapping(str(mapping)), [table]), model.robot, name=name))
    except InputError as error:
        return {"robot": arm.name, "motors": arm.n_motors, "refused": str(error)}
    fitted, held, other = records
    began = time.monotonic()
    result = diagnose(fitted, model, holdout=held, settings=DiagnosisSettings(time_limit=LIMIT))
    seconds = time.monotonic() - began
    write_diagnosis(result, str(arm.robot), folder / "diagnosis")
    patch = folder / "diagnosis" / "patch.yaml"
    repaired = load_patched(patch).model if patch.is_file() else None
    gap, hidden = measure_gap(other, model, repaired=repaired).numbers, expected(truth, model)
    found = named(result.diagnosis)
    return {
        "robot": arm.name,
        "motors": arm.n_motors,
        "truth": {key: value for key, value in asdict(truth).items() if key not in ("causes", "rotors")},
        "hidden": hidden,
        "visible": visible(fitted, model, hidden),
        "named": {name: size for name, (size, _) in found.items()},
        "deviations": {name: deviation for name, (_, deviation) in found.items()},
        "verdict": result.diagnosis.verdict,
        "partial": result.diagnosis.partial is not None,
        "warnings": result.diagnosis.warnings,
        "gap": gap.model_dump(mode="json"),
        "seconds": seconds,
        "code": code_version(),
    }


def main() -> None:
    """Run cases and write the page."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", nargs="*", default=list(EVALUATION), help="MODE:SEED or MODE:SEED:URDF")
    parser.add_argument("--work", type=Path, help="folder for models, logs and reports, which are kept there")
    parser.add_argument("--again", action="store_true", help="forget what is known of these cases")
    parser.add_argument("--results", type=Path, default=Path(__file__).parents[2], help="folder of the page")
    given = parser.parse_args()
    file = given.results / "data" / "mujoco_robots.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    found = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    for text in given.cases:
        case = Case.named(text)
        if text in found and not given.again:
            continue
        with TemporaryDirectory() as made:
            folder = Path(made) if given.work is None else given.work / text.replace(":", "_").replace("/", "_")
            folder.mkdir(parents=True, exist_ok=True)
            found[text] = json.loads(json_text(result_of(case, folder)))
        print(text, found[text].get("verdict", "refused"), flush=True)
        file.write_text(json_text(found), encoding="utf-8")
    (given.results / "mujoco_robots.md").write_text(page(found, DURATION), encoding="utf-8")


if __name__ == "__main__":
    main()
