"""Tables for the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from missions.dates import date_label
from missions.mission import latitude_label
from sizing.results.records import clock_label, hours

if TYPE_CHECKING:  # each command prints its own results alone
    from studies.models.transfer import TransferredError
    from studies.validation.published import Comparison


def print_published(console: Console, rows: list[Comparison]) -> None:
    """Published beside computed numbers."""
    table = Table(title="published and computed", title_justify="left")
    table.add_column("quantity", overflow="fold")
    for name in ("published", "computed", "difference", "allowed"):
        table.add_column(name, justify="right")
    table.add_column("met")
    source = None
    for r in rows:
        if r.source != source:
            source = r.source
            table.add_section()
            table.add_row(source, style="bold")
        table.add_row(
            f"  {r.quantity}",
            f"{r.published:.4g} {r.unit}",
            f"{r.computed:.4g}",
            f"{r.difference:+.2g}",
            f"{r.allowed:.2g}",
            "yes" if r.met else "no",
        )
    console.print(table)


def print_reproduction(console: Console, record: dict[str, Any]) -> None:
    """Report's table and windows, published beside computed, and what the assumptions are worth."""
    table = Table(title="mean solar power, published and computed", title_justify="left")
    table.add_column("mean")
    for name in ("published", "computed", "difference", "flight"):
        table.add_column(name, justify="right")
    for model, row in record["models"].items():
        _add_power_row(table, f"{model}, whole period", row, record["measured_w"])
    for row in record["windows"]:
        name = f"FM, {row['from_h']:g} to {row['to_h']:g} h"
        _add_power_row(table, name, row, row["measured_w"])
    console.print(table)
    spread = Table(title="one assumption changed at a time [W]", title_justify="left")
    spread.add_column("assumption")
    models = list(record["models"])
    for name in (*models, *(f"FM {w['from_h']:g} h" for w in record["windows"])):
        spread.add_column(name, justify="right")
    for case in record["sensitivities"]:
        values = [case["models_w"][m] for m in models] + case["windows_w"]
        spread.add_row(f"{case['assumption']} {case['value']}", *(f"{v:.1f}" for v in values))
    console.print(spread)
    path = record["assumptions"]["flight_path"]
    console.print(
        f"Assumed: {path['kind']} of {path['radius_m']:g} m at {path['airspeed_m_per_s']:g} m/s, "
        f"pitch {path['pitch_deg']:g} deg, wind {record['assumptions']['wind_m_per_s']:g} m/s from "
        f"{record['assumptions']['wind_from_deg']:g} deg, air "
        f"{record['assumptions']['ambient_temperature_c']:g} C.",
        style="dim",
    )


def _add_power_row(table: Table, name: str, row: dict[str, Any], measured_w: float) -> None:
    published, computed = row["published_w"], row["computed_w"]
    table.add_row(
        name,
        f"{published:.2f} W",
        f"{computed:.2f} W",
        f"{100 * (computed / published - 1):+.1f} %",
        f"{measured_w:.1f} W",
    )


def print_transfer(console: Console, errors: list[TransferredError]) -> None:
    """Errors of the simple models against the Full Model on the path, by place, season and wind."""
    winds = sorted({e.wind_m_per_s for e in errors})
    table = Table(title="error of daily solar energy [%]", title_justify="left")
    for name in ("model", "latitude", "date"):
        table.add_column(name)
    for wind in winds:
        table.add_column(f"{wind:g} m/s", justify="right")
    rows: dict[tuple[str, float, int], list[str]] = {}
    for e in errors:
        spread = f" ± {100 * e.half_range:.1f}" if e.wind_m_per_s > 0 else ""
        key = (e.model, e.latitude_deg, e.day_of_year)
        rows.setdefault(key, []).append(f"{100 * e.error:+.1f}{spread}")
    for (model, latitude, day), cells in rows.items():
        table.add_row(model, latitude_label(latitude), date_label(day), *cells)
    console.print(table)
    console.print("±: half the range over eight wind directions", style="dim")


def print_efficiencies(console: Console, data: Any) -> None:
    """Component efficiencies of the Full Model at every full hour of the lit day."""
    table = Table(
        title=f"{data.attrs['aircraft']}, {data.attrs['scenario']} (FM)", title_justify="left"
    )
    names = {
        "time": "solar time",
        "specific_power": "W/m2",
        "module_efficiency": "module",
        "incidence_efficiency": "incidence",
        "low_light_efficiency": "low light",
        "temperature_efficiency": "temperature",
        "mppt_efficiency": "tracker",
    }
    for label in names.values():
        table.add_column(label, justify="right")
    means = data.mean("surface")
    for index, hour in enumerate(means["time"].to_numpy()):
        if abs(hour - round(hour)) > 1e-6:
            continue
        values = [float(means[name][index]) for name in names if name != "time"]
        table.add_row(clock_label(hour), f"{values[0]:.1f}", *(f"{v:.3f}" for v in values[1:]))
    console.print(table)


def print_seasons(console: Console, data: Any, season: Any) -> None:
    """Days of perpetual flight at each latitude, with the first and the last of them."""
    table = Table(title=f"{data.attrs['title']}: perpetual flight", title_justify="left")
    table.add_column("latitude", justify="right")
    table.add_column(f"days of {data.sizes['day']} mapped", justify="right")
    table.add_column("largest excess time", justify="right")
    best = data["excess_time"].max("day")
    for index, latitude in enumerate(data["latitude"].to_numpy()):
        most = float(best[index])
        table.add_row(
            latitude_label(float(latitude)),
            f"{int(season[index])}",
            hours(most if math.isfinite(most) else None, "no end"),
        )
    console.print(table)
