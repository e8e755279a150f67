"""What commands print with `--json`, described for programs: one model per output, from which the schemas are written.

The commands print what the library computes; tests compare what they print with these models.
"""

from __future__ import annotations

from typing import Any

from flexros.cli.json_output.analysis import AnalysisOfRun, ImportedLog
from flexros.cli.json_output.claims import BenchmarkedSpeed, BlindScore, CampaignFigures, Demonstrated
from flexros.cli.json_output.control import (
    Benchmarked,
    BenchmarkedOnRobot,
    BenchmarkLog,
    ControllerEntry,
    Designed,
    MethodEntry,
)
from flexros.cli.json_output.diagnosis import ComparedDiagnoses, Monitored
from flexros.cli.json_output.identification import DesignedExperiment, FrictionMeasured, Identified, ResponseFigures
from flexros.cli.json_output.identified_models import (
    AxisIdentified,
    KinematicIdentified,
    PosesPlanned,
    RigidIdentified,
)
from flexros.cli.json_output.installation import Cleaned, Examined
from flexros.cli.json_output.robots import ExportedModel, ImportedModel, RobotAtPose, RobotEntry
from flexros.cli.json_output.runs import FastestMove, Learned, Replayed, RunOutcome, ScenarioEntry
from flexros.gap.schema import Diagnosis, GapNumbers

OUTPUTS: dict[str, Any] = {
    "robots": list[RobotEntry],
    "robot": RobotAtPose,
    "import": ImportedLog,
    "import-urdf": ImportedModel,
    "import-mjcf": ImportedModel,
    "export": ExportedModel,
    "scenarios": list[ScenarioEntry],
    "run": RunOutcome,
    "learn": Learned,
    "fastest": list[FastestMove],
    "replay": Replayed,
    "analyze": AnalysisOfRun | list[AnalysisOfRun],
    "benchmark": Benchmarked
    | list[Benchmarked]
    | BenchmarkLog
    | BenchmarkedOnRobot
    | list[BenchmarkedOnRobot]
    | list[ControllerEntry],
    "design": Designed | dict[str, MethodEntry],
    "diagnose": Diagnosis,
    "compare": ComparedDiagnoses,
    "gap": GapNumbers,
    "monitor": Monitored,
    "doctor": Examined,
    "clean": Cleaned,
    "identify robot": Identified,
    "identify design": DesignedExperiment,
    "identify frf": list[ResponseFigures],
    "identify fit": Identified,
    "identify friction": FrictionMeasured,
    "identify rigid": RigidIdentified,
    "identify axis": AxisIdentified,
    "identify kinematics": KinematicIdentified | PosesPlanned,
    "demo": Demonstrated,
    "bench": BenchmarkedSpeed,
    "campaign": dict[str, CampaignFigures],
    "blind score": BlindScore,
}
"""Type of the output of each command, by its words."""
