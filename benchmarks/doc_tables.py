"""Tables of the documentation, written by the software itself: ``python -m benchmarks.doc_tables``.

A table stands between the markers ``<!-- NAME -->`` and ``<!-- /NAME -->`` of a page.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib.resources import files
from pathlib import Path

from benchmarks.validation import altitude_tables, clear_sky_comparison, found_designs
from benchmarks.validation.large_wings import large_wings_table
from benchmarks.validation.loiter_correction import transfer_table, transferred_errors
from benchmarks.validation.published import published_table
from benchmarks.validation.published_flights import facts_table
from benchmarks.validation.season import seasons_table
from benchmarks.validation.single_inputs import explain, explanations_table
from benchmarks.validation.slender_wings import aspect_ratio_table
from benchmarks.validation.structure_comparison import gust_table, structure_tables
from benchmarks.validation.structures import qualities_table, structures_table
from benchmarks.validation.team_designs import team_designs_table, weighed_parts_table
from benchmarks.validation.zephyr import zephyr_table
from missions.files.writing import write_bytes_atomically
from missions.library import load_mission
from missions.weather.files import load_weather
from sizing.battery.condition import Ageing
from sizing.library import load_aircraft
from sizing.results.sizing import size, size_in_weather
from sizing.results.sizing_study import SizingStudy
from sizing.results.weather import analyse_weather
from sizing.roots import bisect
from studies.models.comparison import compare
from studies.models.report_reproduction import reference, reproduce
from studies.render.tables import Column, Table


def _markdown(*tables: Table) -> str:
    return "\n".join(table.to_markdown() for table in tables)


def _clear_sky() -> str:
    return _markdown(clear_sky_comparison.clear_sky_table(clear_sky_comparison.compare()))


def _light() -> str:
    return _markdown(clear_sky_comparison.light_table(clear_sky_comparison.light_up_to()))


def _comparison(aircraft: str, mission: str, required_h: float) -> str:
    found = compare(
        load_aircraft(aircraft), load_mission(mission), required_excess_time_h=required_h
    )
    # What the models predict of one aircraft is enough; of the other, the designs they lead to.
    return f"{_markdown(found.tables()[-1])}\n{found.headline()}\n"


def _battery_life() -> str:
    """Cycles to the end of a battery's life, a cycle a day."""
    temperatures_c = (0.0, 10.0, 25.0, 35.0)
    columns = (
        Column("depth of discharge"),
        *(Column(f"at_{t:.0f}", f"stored at {t:.0f} C") for t in temperatures_c),
    )

    def cycles(new: Ageing) -> float:
        """Return the number of cycles, to 0.1 %, after which 80 % of the capacity is left."""

        def is_over(cycles: float) -> bool:
            aged = {"cycles": cycles, "months": cycles * 12.0 / 365.0}
            return bool(new.model_copy(update=aged).capacity_fraction() <= 0.8)

        return bisect(1.0, math.inf, is_over, lambda cycles: 1e-3 * cycles)

    rows = []
    for depth in (0.2, 0.4, 0.6, 0.8, 1.0):
        lives = (cycles(Ageing(depth_of_discharge=depth, temperature_c=t)) for t in temperatures_c)
        rows.append((f"{100.0 * depth:.0f} %", *(f"{life:.0f}" for life in lives)))
    return _markdown(Table("", columns, tuple(rows)))


def _reliabilities() -> str:
    """Wingspans that a probability of three hours of excess time takes."""
    columns = (
        Column("asked", "reliability asked for"),
        Column("wingspan", "wingspan [m]"),
        Column("mass", "total mass [kg]"),
        Column("found", "found in independent draws"),
    )
    aircraft = load_aircraft("atlantiksolar-design")
    mission = load_mission("rafz-july", {"required_excess_time_h": 3.0})
    nominal = size(aircraft, mission, "min_wingspan")
    rows: list[tuple[str, ...]] = []
    for asked in (0.9, 0.95, 0.99):
        found = size(aircraft, mission, "min_wingspan", reliability=asked)
        assert found.reliability is not None
        if not rows:
            rows.append(("none", *_size_of(nominal), found.reliability.nominal.text()))
        rows.append((f"{100 * asked:.0f} %", *_size_of(found), found.reliability.achieved.text()))
    return _markdown(Table("", columns, tuple(rows)))


def _season_shares() -> str:
    """Wingspans that a share of the days of a real season takes."""
    columns = (
        Column("asked", "required share"),
        Column("wingspan", "wingspan [m]"),
        Column("mass", "total mass [kg]"),
        Column("days", "days that close"),
        Column("gap", "longest gap [d]"),
    )
    place = {"latitude_deg": 40.5, "altitude_m": 2300.0}
    mission = load_mission("central-europe-summer", place)
    rows = []
    for asked in (0.5, 0.9, 0.99):
        found = size_in_weather(
            load_aircraft("atlantiksolar-design"),
            mission,
            load_weather("colorado-2023"),
            "min_wingspan",
            survive=asked,
        )
        assert found.survival is not None
        days = found.survival.days
        closed = f"{days.that_close} of {len(days)}"
        gap = str(days.longest_gap_days)
        rows.append((f"{100 * asked:.0f} %", *_size_of(found), closed, gap))
    return _markdown(Table("", columns, tuple(rows)))


def _sites() -> str:
    """Days of typical years and of a year in which AtlantikSolar AS-2 flies on."""
    columns = (
        *(Column(name) for name in ("site", "record", "days", "close", "corrected", "clear sky")),
        *(Column(name) for name in ("longest run", "endurance P10, P50, P90 [h]", "light")),
    )
    folder, rows = files("pvlib") / "data", []
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-july")
    for name, kind in (
        ("703165TY.csv", "TMY3"),
        ("723170TYA.CSV", "TMY3"),
        ("12839.tm2", "TMY2"),
        ("colorado-2023", "NSRDB 2023"),
    ):
        weather = load_weather(str(folder / name) if "." in name else name)
        plain, corrected = (
            analyse_weather(aircraft, mission, weather, correction=by, mission_chosen=False)
            for by in ("none", "report")
        )
        flown = plain.performance
        rows.append(
            (
                f"{weather.site.name}, {weather.site.latitude_deg:.1f}° N",
                kind,
                str(plain.days),
                str(plain.days_that_close),
                str(corrected.days_that_close),
                str(int(flown.clear.closes.sum())),
                str(flown.recorded.longest_run_days),
                ", ".join(f"{plain.endurance_h[p]:.0f}" for p in ("p10", "p50", "p90")),
                f"{100.0 * plain.share_of_clear_light():.0f} %",
            )
        )
    return _markdown(Table("", columns, tuple(rows)))


def _size_of(found: SizingStudy) -> tuple[str, str]:
    """Wingspan [m] and total mass [kg] of a sized aircraft."""
    assert found.variables is not None
    assert found.design is not None
    return f"{found.variables.wingspan_m:.2f}", f"{found.design.total_mass_kg:.2f}"


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "published": ("validation.md", lambda: _markdown(published_table())),
    "flights": ("tables/flights.md", lambda: _markdown(facts_table())),
    "single-inputs": ("tables/single-inputs.md", lambda: _markdown(explanations_table(explain()))),
    "season": ("validation.md", lambda: _markdown(seasons_table())),
    "clear-sky": ("tables/clear-sky.md", _clear_sky),
    "found-designs": ("validation.md", lambda: _markdown(found_designs.found_table())),
    "report": ("tables/report.md", lambda: _markdown(*reproduce(*reference(), vary=True).tables())),
    "structure": ("tables/structure.md", lambda: _markdown(*structure_tables())),
    "large-wings": ("structure.md", lambda: _markdown(large_wings_table())),
    "team-designs": (
        "validation.md",
        lambda: _markdown(team_designs_table(), weighed_parts_table()),
    ),
    "build-qualities": ("structure.md", lambda: _markdown(qualities_table())),
    "published-structures": ("structure.md", lambda: _markdown(structures_table())),
    "gusts": ("structure.md", lambda: _markdown(gust_table())),
    "aspect-ratio": ("tables/aspect-ratio.md", lambda: _markdown(aspect_ratio_table())),
    "transfer": (
        "tables/transfer.md",
        lambda: _markdown(transfer_table(transferred_errors(*reference()))),
    ),
    "light": ("altitude.md", _light),
    "battery-life": ("battery.md", _battery_life),
    "reliabilities": ("uncertainty.md", _reliabilities),
    "season-shares": ("season.md", _season_shares),
    "sites": ("weather.md", _sites),
    "ceilings": ("altitude.md", lambda: _markdown(altitude_tables.ceilings())),
    "module-heat": ("altitude.md", lambda: _markdown(altitude_tables.module_heat())),
    "zephyr": ("stratosphere.md", lambda: _markdown(zephyr_table())),
    "climbs": ("altitude.md", lambda: _markdown(altitude_tables.climbs())),
    "compare-as2": ("compare.md", partial(_comparison, "atlantiksolar-as2", "rafz-july", 0.0)),
    "compare-design": (
        "compare.md",
        partial(_comparison, "atlantiksolar-design", "central-europe-summer", 3.0),
    ),
}


def with_table(page: str, name: str, table: str) -> str:
    """Page with a table put between its markers.

    Parameters
    ----------
    page : str
        Text of the page, in Markdown.
    name : str
        Name in the markers, ``<!-- name -->`` and ``<!-- /name -->``.
    table : str
        What comes between them.

    Returns
    -------
    str
        Text of the page.

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
            write_bytes_atomically(path, after.encode())
            changed.append(path)
    return changed


def main(arguments: Sequence[str]) -> int:
    """Write the tables into the pages of a folder; the exit code is 1 where that cannot be.

    Parameters
    ----------
    arguments : sequence of str
        The folder; ``docs`` in the working folder if there is none.
    """
    folder = Path(arguments[0] if arguments else "docs")
    pages = dict.fromkeys(page for page, _ in TABLES.values())
    missing = [page for page in pages if not (folder / page).is_file()]
    if missing:
        print(
            f"{folder} has no {missing[0]}: start this in a clone of the project, or name the "
            "folder of the pages",
            file=sys.stderr,
        )
        return 1
    try:
        changed = update(folder)
    except ImportError as error:
        print(f"{error}: install the extra 'test', pip install '.[test]'", file=sys.stderr)
        return 1
    for page in changed:
        print(f"updated {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
