"""Draw the picture of the landing page from a diagnosis: journey_picture.py DIAGNOSIS.json GAP.json PICTURE.svg.

GAP.json is the output of `flexros gap --patch --json` on a log that nothing was fitted to.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

COLOURS = {"Coulomb friction": "#c2571a", "viscous friction": "#e0a458", "other effects": "#7a7f87"}
NAMES = {"coulomb_friction": "Coulomb friction", "viscous_friction": "viscous friction"}
WIDTH, HEIGHT = 960, 300
INK, PAPER, BLUE = "#24292f", "#f6f7f9", "#1f5fa8"


def text(x: float, y: float, words: str, size: int = 15, *, bold: bool = False, colour: str = INK) -> str:
    """Return a line of text, centred."""
    weight = "bold" if bold else "normal"
    return (
        f'<text x="{x:g}" y="{y:g}" font-size="{size}" font-weight="{weight}" fill="{colour}" '
        f'text-anchor="middle">{escape(words)}</text>'
    )


def box(x: float, width: float, title: str, colour: str = PAPER) -> str:
    """Return a frame with a title."""
    frame = f'<rect x="{x}" y="10" width="{width}" height="{HEIGHT - 20}" rx="10" fill="{colour}" stroke="#c9ced6"/>'
    return frame + text(x + width / 2, 42, title, 19, bold=True)


def arrow(x: float, words: str) -> str:
    """Return an arrow with the command above it."""
    y = HEIGHT / 2
    path = f'<path d="M{x} {y}h56m-12 -9l12 9l-12 9" fill="none" stroke="{BLUE}" stroke-width="4"/>'
    return path + text(x + 28, y - 20, words, 14, bold=True, colour=BLUE)


def budget(diagnosis: dict[str, Any], x: float, width: float) -> str:
    """Return bars of the gap by joint, divided among effects."""
    shares: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    for row in diagnosis["budget"]:
        if row["effect"]:
            shares[row["location"]][NAMES.get(row["effect"], "other effects")] += max(row["share_last"], 0.0)
    whole = max(sum(row.values()) for row in shares.values())
    drawn, left, room = [], x + 92, width - 112
    for k, (joint, parts) in enumerate(sorted(shares.items())):
        y, at = 62 + 28 * k, float(left)
        drawn.append(text(x + 48, y + 14, joint.replace("motor_", "joint "), 14))
        for name, colour in COLOURS.items():
            length = room * parts.get(name, 0.0) / whole
            drawn.append(f'<rect x="{at:.1f}" y="{y}" width="{length:.1f}" height="18" fill="{colour}"/>')
            at += length
    for k, (name, colour) in enumerate(list(COLOURS.items())[:2]):
        drawn.append(f'<rect x="{x + 30 + 150 * k}" y="{HEIGHT - 52}" width="14" height="14" fill="{colour}"/>')
        drawn.append(text(x + 108 + 150 * k, HEIGHT - 40, name, 14))
    return "".join(drawn)


def picture(diagnosis: dict[str, Any], gap: dict[str, float]) -> str:
    """Return the picture."""
    load = next((row["value"] for row in diagnosis["model_numbers"] if row["name"] == "tool_load.mass"), None)
    lines = ["friction at 6 joints", "6 rotors"] + ([f"tool of {load:.2f} kg"] if load else [])
    parts = [
        box(10, 190, "you have"),
        *(text(105, 105 + 34 * k, line) for k, line in enumerate(("a URDF or MJCF", "a bag or CSV", "of your arm"))),
        arrow(212, "diagnose"),
        box(280, 380, "what differs, by joint"),
        budget(diagnosis, 280, 380),
        arrow(672, "export"),
        box(740, 210, "a repaired model"),
        *(text(845, 84 + 28 * k, line) for k, line in enumerate(lines)),
        text(845, 196, "error on a second log", 15),
        text(845, 230, f"{gap['before']:.0f} → {gap['after']:.2f}", 26, bold=True, colour=BLUE),
        text(845, 258, "times the noise floor", 14),
    ]
    size, fonts = f'viewBox="0 0 {WIDTH} {HEIGHT}"', 'font-family="Helvetica, Arial, sans-serif"'
    paper = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {fonts}>{paper}{"".join(parts)}</svg>\n'


if __name__ == "__main__":
    found, measured = (json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:3])
    Path(sys.argv[3]).write_text(picture(found, measured), encoding="utf-8")
