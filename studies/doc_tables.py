"""Tables of the documentation, written by the software itself: ``python -m studies.doc_tables``.

A table stands between the markers ``<!-- NAME -->`` and ``<!-- /NAME -->`` of a page.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from missions.files.writing import write_text_atomically
from missions.library import load_mission
from sizing.library import load_aircraft
from studies.models import transfer as model_transfer
from studies.models.comparison import compare
from studies.validation import (
    altitude_tables,
    clear_sky_comparison,
    found_designs,
    published,
    report_reproduction,
    structure_comparison,
)


def _published() -> str:
    return published.markdown(published.comparisons())


def _report() -> str:
    aircraft, mission = report_reproduction.reference()
    result = report_reproduction.reproduce(aircraft, mission)
    varied = report_reproduction.sensitivities(aircraft, mission)
    return report_reproduction.markdown(result, varied)


def _transfer() -> str:
    errors = model_transfer.transferred_errors(*report_reproduction.reference())
    return model_transfer.transfer_table(errors).to_markdown()


def _clear_sky() -> str:
    return clear_sky_comparison.markdown(clear_sky_comparison.compare())


def _structure() -> str:
    return structure_comparison.markdown()


def _comparison(aircraft: str, mission: str, required_h: float) -> str:
    found = compare(
        load_aircraft(aircraft), load_mission(mission), required_excess_time_h=required_h
    )
    return "\n".join([*(table.to_markdown() for table in found.tables()), found.headline() + "\n"])


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "published": ("validation.md", _published),
    "clear-sky": ("validation.md", _clear_sky),
    "found-designs": ("validation.md", found_designs.markdown),
    "report": ("validation.md", _report),
    "structure": ("structure.md", _structure),
    "transfer": ("full-model.md", _transfer),
    "ceilings": ("altitude.md", altitude_tables.ceilings),
    "climbs": ("altitude.md", altitude_tables.climbs),
    "compare-as2": ("compare.md", partial(_comparison, "atlantiksolar-as2", "rafz-july", 0.0)),
    "compare-design": (
        "compare.md",
        partial(_comparison, "atlantiksolar-design", "central-europe-summer", 3.0),
    ),
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
