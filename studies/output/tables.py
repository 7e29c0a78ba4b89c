"""Tables for the terminal."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from missions.mission import latitude_label
from sizing.results.records import hours


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
