"""Draw the pictures of the gallery: python docs/generate/gallery_pictures.py FOLDER, from the checkout, with Chromium.

FOLDER holds the results of the commands on that page: circle.html, two_mass_identified, diagnosis.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.browser import Browser, opened_browser

PICTURES = Path(__file__).parents[1] / "pictures" / "gallery"
REPORTS = {
    "runs": ("circle.html", "Path"),
    "diagnosis": ("diagnosis/report.html", ""),
    "budget": ("diagnosis/report.html", "The budget of the gap"),
    "evidence": ("diagnosis/report.html", "The evidence"),
    "identification": ("two_mass_identified/report.html", "Frequency responses"),
}
"""Report, and heading at the top of the window, by picture."""
WIDTH, HEIGHT = 1180, 760
TALLEST = 1300
"""Height of a window that shows the first figure below the heading whole [px], as that of a budget of six motors."""
COLOURS = 64
DRAWN = 3.0
"""Time for figures that are drawn when they come into view [s]."""


def main(folder: Path) -> None:
    """Draw all pictures, in few colours."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with opened_browser() as browser:
        for name, (report, heading) in REPORTS.items():
            browser.size(WIDTH, TALLEST)
            browser.open(folder / report)
            if heading:
                found = f"[...document.querySelectorAll('h2')].find(h => h.textContent.startsWith('{heading}'))"
                browser.value(f"{found}.scrollIntoView()")
            time.sleep(DRAWN)
            whole = browser.picture()
            picture = Image.fromarray(whole[: _end(browser)]).quantize(COLOURS)
            picture.save(PICTURES / f"{name}.png", optimize=True)


def _end(browser: Browser) -> int:
    """Return where the last paragraph or figure ends that the window shows whole, beyond HEIGHT for a tall one [px]."""
    blocks = "[...document.querySelectorAll('main > section > *, main > header, main > *')]"
    edges = browser.value(
        f"{blocks}.filter((e) => e.matches('p, figure, .tiles')).map((e) => e.getBoundingClientRect())"
        ".filter((r) => r.height > 0 && r.top >= 0).map((r) => r.bottom)"
    )
    shown = [edge for edge in edges if edge <= HEIGHT] or [min(edges)]
    figure = browser.value(
        "Math.min(...[...document.querySelectorAll('figure')].map((e) => e.getBoundingClientRect())"
        ".filter((r) => r.height > 0 && r.top >= 0).map((r) => r.bottom))"
    )
    end: float = max(*shown, figure if figure <= TALLEST else 0.0)
    return min(TALLEST, round(end) + 12)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
