"""Colours with a meaning, the same in every report and in the viewer, and their likenesses on a dark page."""

from __future__ import annotations

MEASURED, NOMINAL, REPAIRED, RIVAL, FLOOR = "#59636e", "#d55e00", "#0072b2", "#e69f00", "#a9b4bf"
"""Colours of what was measured, the nominal model, the repaired or identified one, a rival, and noise alone."""

DARK = {
    "#ffffff": "#14181d",
    "#1b1f24": "#e3e7ec",
    "#59636e": "#a3adb8",
    "#e7eaee": "#2a3139",
    "#8b949e": "#6b7580",
    "#d5dae0": "#343c46",
    "#f6f8fa": "#1d232a",
    "#0072b2": "#4aa8ea",
    "#d55e00": "#f58a45",
    "#009e73": "#35c79c",
    "#5e3c99": "#ab91e0",
    "#8c510a": "#c9904f",
    "#b35900": "#e08a3c",
    "#cfe2f0": "#1f3d55",
    "#b8c0c8": "#56606b",
    "#8fb8d8": "#3f647f",
}
"""Colour on a dark page of each colour on a light one; those that are missing serve on both."""
