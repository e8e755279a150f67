"""Campaign: does the identified model make the path error of the real robot smaller?"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, ClassVar

from flexros.provenance import versions
from flexros.report.number_text import number
from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.markdown import version_line

if TYPE_CHECKING:
    from flexros.validation.campaigns.base import CampaignRequest
    from flexros.validation.campaigns.path_improvement.comparison import Improvement

PAGE, FIGURES = "identification_path.md", "data/identification_path.json"

EXPERIMENT = "identify_e12"
REAL = {"body_1.ry.stiffness": 0.8, "body_2.ry.stiffness": 1.2, "body_3.ry.stiffness": 0.8}
"""Springs of the real robot over those of the nominal one."""
MOTIONS = ("circle_dae", "circle_dae2", "circle_fj")
"""The circle test of Paper B, without sensor noise as there."""


class PathErrors(AbstractCampaign):
    """Circle test on a robot with springs 20 % off, with feedforward from the nominal and from the identified model."""

    name: ClassVar[str] = "path_improvement"
    question: ClassVar[str] = "Does the identified model reduce the path error of the real robot?"

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, which takes less than a minute, so nothing is kept; see `AbstractCampaign.run`."""
        from flexros.scenario.scenario import load_scenario
        from flexros.validation.campaigns.path_improvement.comparison import identify_and_compare

        request.progress("identification and circles", 0, 1)
        future = request.client.submit(
            identify_and_compare,
            load_scenario(EXPERIMENT),
            REAL,
            MOTIONS,
            request.work.resolve() / "identified.yaml",
            pure=False,
        )
        comparison = future.result()
        request.progress("identification and circles", 1, 1)
        used = versions()
        record = {"experiment": EXPERIMENT, "real": REAL, **asdict(comparison), "versions": used}
        return CampaignResult(
            files={PAGE: _page(comparison, used), FIGURES: json.dumps(record, indent=1) + "\n"},
            record=record,
            summary=_summary(comparison),
        )


def _summary(found: Improvement) -> tuple[str, ...]:
    return tuple(
        f"{one.motion}: largest path error {1e3 * one.nominal:.3g} mm with the nominal model, "
        f"{1e3 * one.identified:.3g} mm with the identified one ({number(one.factor, 3)} times smaller), "
        f"{1e3 * one.true:.3g} mm with the true one."
        for one in found.paths
    )


def _page(found: Improvement, used: dict[str, str]) -> str:
    paths = [
        f"| {one.motion} | {one.method} | {1e3 * one.nominal:.3g} | {1e3 * one.identified:.3g} | {1e3 * one.true:.3g} "
        f"| {number(one.factor, 3)} |"
        for one in found.paths
    ]
    values = [
        f"| {name} | {nominal:g} | {true:g} | {value:.6g} | {100 * relative:.2g} | {100 * (value / true - 1):.2g} |"
        for name, (nominal, true, value, relative) in found.parameters.items()
    ]
    lines = [
        "# Path error with an identified model",
        "",
        "Written by `flexros campaign path_improvement` (`make campaign`).",
        "",
        f"The real robot is E12 with springs 20 % off: {', '.join(f'{name} x {f:g}' for name, f in REAL.items())}. "
        f"It is identified by the experiment `{EXPERIMENT}` (encoder noise as in its file) from the nominal model. "
        "Then it moves along the circle of Paper B with feedforward from three models; the controller is the same.",
        "",
        "| scenario | feedforward | nominal model [mm] | identified model [mm] | true model [mm] | times smaller |",
        "|---|---|---|---|---|---|",
        *paths,
        "",
        "Largest distance from the circle. The error with the true model is that of the method.",
        "",
        "| parameter | nominal | true | identified | std [%] | error [%] |",
        "|---|---|---|---|---|---|",
        *values,
        "",
        f"Stiffness in Nm/rad, damping in Nms/rad. {version_line(used)}.",
    ]
    return "\n".join(lines) + "\n"
