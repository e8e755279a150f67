"""Published results of the benchmark (Moberg 2007, Paper C, Tables 1 and 2): the same scale, not reproduced here."""

from __future__ import annotations

PUBLISHED_V1: dict[str, tuple[float, ...]] = {
    "A": (8.22, 2.56, 5.39, 1.58, 7.78, 2.82, 4.88, 1.40, 2.04, 1.25, 1.04, 0.95, 2.67, 12.1, 1.53, 82.5),
    "B": (8.57, 2.43, 5.56, 1.74, 8.22, 2.82, 5.13, 1.56, 2.13, 1.47, 0.77, 0.55, 1.05, 12.0, 1.52, 80.8),
    "C": (9.75, 3.41, 5.34, 2.12, 9.37, 4.02, 4.20, 1.90, 1.79, 1.52, 0.71, 0.69, 1.85, 11.0, 1.43, 84.8),
    "D": (9.11, 3.22, 5.28, 1.77, 8.64, 3.68, 4.59, 1.57, 1.68, 1.05, 0.77, 0.71, 1.66, 11.3, 1.46, 80.5),
}
"""Table 1, model set M1: e1 to e8 [mm], Ts1 to Ts4 [s], T_NOISE, T_MAX, T_RMS [Nm], V_1, by solution."""

PUBLISHED: dict[str, tuple[float, float, float, float]] = {
    "A": (64.6, 82.5, 82.6, 146.0),
    "B": (58.8, 80.8, 84.2, 141.4),
    "C": (64.8, 84.8, 84.1, 148.9),
    "D": (62.0, 80.5, 81.6, 142.2),
}
"""Table 2: V_nom, V_1, V_2 and V by solution."""

SOLUTIONS = {"A": "QFT", "B": "QFT of order 13", "C": "polynomial", "D": "linear sliding mode"}
"""What the published solutions are."""
