"""Pictures of the signatures of an effect in the log."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.signatures.base import pictures_for
from flexros.report.base import Picture
from flexros.report.colours import NOMINAL, REPAIRED

if TYPE_CHECKING:
    from collections.abc import Iterable

    import plotly.graph_objects as go

    from flexros.gap.result import DiagnosisResult, RankedCandidate
    from flexros.gap.signatures.base import Curve
    from flexros.gap.signatures.base import Picture as Signature

MOST = 2
"""Pictures of one effect at most, the clearest first (chosen)."""
_COLOURS = (NOMINAL, REPAIRED, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Colours of lines in their order: first the nominal model, then the repaired one."""
_POINTS = ("#b8c0c8", "#8fb8d8")
"""Colours of clouds of points, which lie below the lines."""
_HEIGHT = 260
_WITHIN = (0.005, 0.995)
"""Quantiles of a cloud of points that are in the picture at least: outliers would flatten the curves (chosen)."""
_MARGIN = 0.06
"""Free height above and below, as a share (chosen)."""
_ACROSS = 32
"""Characters of an ordinate's title that fit next to a picture."""


def signature_pictures(candidate: RankedCandidate, result: DiagnosisResult) -> tuple[Picture, ...]:
    """Draw the signature of an effect in the log.

    Args:
        candidate: The effect.
        result: The diagnosis.

    Returns:
        Its pictures, the clearest first; none where the log cannot show it.
    """
    data = result.signature_data
    if data is None:
        return ()
    pictures = (kind().picture(data, candidate.location) for kind in pictures_for(candidate.effect))
    drawn = [signature for picture in pictures if picture is not None and (signature := _shown(picture)).series]
    return tuple(Picture(_figure(signature), f"{signature.title}. {signature.reading}") for signature in drawn[:MOST])


def _shown(signature: Signature) -> Signature:
    """Return a picture without curves that have no point: of a short log no part has enough samples for a mean."""
    series = {name: curve for name, curve in signature.series.items() if np.isfinite(curve.y).any()}
    return replace(signature, series=series)


def _figure(signature: Signature) -> go.Figure:
    from flexros.report.theme import LOGARITHMIC, stacked

    figure = stacked([""], height=_HEIGHT)
    clouds = {name: curve for name, curve in signature.series.items() if curve.style == "points"}
    lines = {name: curve for name, curve in signature.series.items() if curve.style != "points"}
    for colours, curves in ((_POINTS if lines else _COLOURS, clouds), (_COLOURS, lines)):
        for index, (name, curve) in enumerate(curves.items()):
            figure.add_trace(_trace(_spoken(name), curve, colours[index % len(colours)], 3 if lines else 6))
    figure.update_xaxes(title_text=signature.x_label, **(LOGARITHMIC if signature.log_x else {}))
    title = "<br>".join(textwrap.wrap(signature.y_label, _ACROSS))
    figure.update_yaxes(title_text=title, title_standoff=12, **(LOGARITHMIC if signature.log_y else {}))
    if clouds and lines and not signature.log_y:
        figure.update_yaxes(range=_range(clouds.values(), lines.values()))
    figure.update_layout(showlegend=len(signature.series) > 1, legend_itemsizing="constant", margin_l=104)
    return figure


def _range(clouds: Iterable[Curve], lines: Iterable[Curve]) -> list[float]:
    """Return the range of an ordinate that shows lines whole and clouds without their outliers."""
    ends = [np.nanquantile(cloud.y, _WITHIN) for cloud in clouds]
    ends += [np.array([np.nanmin(line.y), np.nanmax(line.y)]) for line in lines]
    low, high = min(end[0] for end in ends), max(end[1] for end in ends)
    margin = _MARGIN * (high - low)
    return [float(low - margin), float(high + margin)]


def _spoken(name: str) -> str:
    """Return the name of a curve in the words of the report."""
    words = {"before": "nominal model", "after": "repaired model"}
    return ", ".join(words.get(part, part) for part in name.split(", "))


def _trace(name: str, curve: Curve, colour: str, size: int) -> go.Scatter | go.Bar:
    import plotly.graph_objects as go

    from flexros.report.theme import compact

    x, y = compact(curve.x), compact(curve.y)
    hover = f"%{{x:.4g}}: %{{y:.4g}}<extra>{name}</extra>"
    if curve.style == "bars":
        return go.Bar(x=x, y=y, name=name, marker={"color": colour}, hovertemplate=hover)
    if curve.style == "points":
        marker = {"color": colour, "size": size}
        return go.Scatter(x=x, y=y, name=name, mode="markers", marker=marker, hovertemplate=hover)
    return go.Scatter(x=x, y=y, name=name, mode="lines", line={"color": colour, "width": 1.8}, hovertemplate=hover)
