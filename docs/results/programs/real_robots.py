"""Write real_robots.md: FLEXROS_REALDATA=... python docs/results/programs/real_robots.py WORK --fetched FOLDER.

Each case leaves docs/results/data/real_robots/NAME.json step by step, so that a run which was interrupted continues;
what is there is not computed again (`--again` does). `--cases NAME...` runs some cases, `--cases` alone none. The page
is written from these files. Cases whose data are not there are skipped with the reason; the exit code is then 1. Logs,
robot files and reports of the diagnoses stay in WORK.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from real_robots_cases import CASES
from real_robots_page import page
from real_robots_run import Run

from flexros.errors import InputError

if TYPE_CHECKING:
    from real_robots_case import Case

LIMIT = 3600.0
"""Time after which a diagnosis is partial, by default [s]."""


def data_of(case: Case, fetched: Path | None) -> Path:
    """Find the folder of the data of a case.

    Raises:
        InputError: It is not there.
    """
    if case.fetched and fetched is None:
        fetching = "docs/results/programs/measured/fetch_real_robots.py"
        raise InputError(f"its data are fetched by {fetching}; name their folder by --fetched")
    given = fetched if case.fetched else Path(os.environ.get("FLEXROS_REALDATA", "") or "/nowhere")
    assert given is not None
    folder = given / case.folder
    missing = [name for name in case.fitted if not (folder / name).is_file()]
    if missing:
        where = "the fetched folder" if case.fetched else "FLEXROS_REALDATA"
        raise InputError(f"{where} has no {case.folder}/{missing[0]}")
    return folder


def main() -> int:
    """Run cases and write the page."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("work", type=Path, help="folder for logs, robot files and reports")
    parser.add_argument("--fetched", type=Path, help="folder of fetch_real_robots.py")
    parser.add_argument("--cases", nargs="*", default=[case.name for case in CASES], choices=[c.name for c in CASES])
    parser.add_argument("--again", action="store_true", help="forget what is known of these cases")
    parser.add_argument("--limit", type=float, default=LIMIT, help="time after which a diagnosis is partial [s]")
    parser.add_argument("--results", type=Path, default=Path(__file__).parents[1], help="folder of the page")
    given = parser.parse_args()
    jsons, skipped = given.results / "data" / "real_robots", 0
    for case in CASES:
        if case.name not in given.cases:
            continue
        work, result = given.work / case.name, jsons / f"{case.name}.json"
        if given.again:
            result.unlink(missing_ok=True)
            shutil.rmtree(work, ignore_errors=True)
        try:
            Run(case, data_of(case, given.fetched), work, result, given.limit).all_steps()
        except InputError as error:
            print(f"skipped: {case.name}: {error}", file=sys.stderr)
            skipped += 1
    found = {
        case.name: json.loads((jsons / f"{case.name}.json").read_text(encoding="utf-8"))
        for case in CASES
        if (jsons / f"{case.name}.json").is_file()
    }
    (given.results / "real_robots.md").write_text(page(found), encoding="utf-8")
    return 1 if skipped else 0


if __name__ == "__main__":
    sys.exit(main())
