"""Tables of the documentation, written by the software itself: ``python -m studies.doc_tables``.

A table stands between the markers ``<!-- NAME -->`` and ``<!-- /NAME -->`` of a page.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

from missions.output_files import write_text_atomically
from studies import (
    altitude_tables,
    clear_sky_comparison,
    model_transfer,
    published,
    report_reproduction,
)


def _published() -> str:
    return published.markdown(published.comparisons())


def _report() -> str:
    aircraft, mission = report_reproduction.reference()
    result = report_reproduction.reproduce(aircraft, mission)
    varied = report_reproduction.sensitivities(aircraft, mission)
    return report_reproduction.markdown(result, varied)


def _transfer() -> str:
    return model_transfer.markdown(
        model_transfer.transferred_errors(*report_reproduction.reference())
    )


def _clear_sky() -> str:
    return clear_sky_comparison.markdown(clear_sky_comparison.compare())


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "published": ("validation.md", _published),
    "clear-sky": ("validation.md", _clear_sky),
    "report": ("validation.md", _report),
    "transfer": ("full-model.md", _transfer),
    "ceilings": ("altitude.md", altitude_tables.ceilings),
    "climbs": ("altitude.md", altitude_tables.climbs),
}


def with_table(page: str, name: str, table: str) -> str:
    """Page with a table put between its markers.

    Raises
    ------
    ValueError
        If the page does not have exactly one pair of the markers.
    """
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
    found = pattern.findall(page)
    if len(found) != 1:
        raise ValueError(f"need one pair of markers for {name}, found {len(found)}")
    return pattern.sub(lambda m: f"{m[1]}\n{table}\n{m[2]}", page)


def update(folder: Path) -> list[Path]:
    """Write all tables into the pages of a folder; returns the pages that changed."""
    changed = []
    for name, (page, make) in TABLES.items():
        path = folder / page
        before = path.read_text(encoding="utf-8")
        after = with_table(before, name, make())
        if after != before:
            write_text_atomically(path, after)
            changed.append(path)
    return changed


if __name__ == "__main__":
    for page in update(Path(sys.argv[1] if len(sys.argv) > 1 else "docs")):
        print(f"updated {page}")
