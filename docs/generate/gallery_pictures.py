"""Draw the pictures of the gallery: python docs/generate/gallery_pictures.py FOLDER, from the checkout, with Chromium.

FOLDER holds the results of the commands on that page: circle.html, two_mass_identified, diagnosis.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.browser import opened_browser

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
COLOURS = 64
DRAWN = 3.0
"""Time for figures that are drawn when they come into view [s]."""


def main(folder: Path) -> None:
    """Draw all pictures, in few colours."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with opened_browser() as browser:
        browser.size(WIDTH, HEIGHT)
        for name, (report, heading) in REPORTS.items():
            browser.open(folder / report)
            if heading:
                found = f"[...document.querySelectorAll('h2')].find(h => h.textContent.startsWith('{heading}'))"
                browser.value(f"{found}.scrollIntoView()")
            time.sleep(DRAWN)
            picture = Image.fromarray(browser.picture()).quantize(COLOURS)
            picture.save(PICTURES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
