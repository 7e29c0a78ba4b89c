"""The command ``solar-uav analyse``."""

from __future__ import annotations

from dataclasses import dataclass

import click

from studies.cli.command import Command
from studies.cli.options import (
    CaseOptions,
    PlaceOptions,
    case_options,
    figure_options,
    mass_option,
    place_options,
    plot_option,
    table_option,
    weather_option,
)
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class Analyse:
    """Analyse how long AIRCRAFT (name, file or folder) flies, there and then."""

    case: CaseOptions = case_options(with_levels=True)
    place: PlaceOptions = place_options()
    mass_kg: float | None = mass_option()
    weather_file: str | None = weather_option(
        "Fly through a weather record: EPW, TMY2, TMY3, PVGIS, SAM, BSRN, POWER, ERA5 or plain CSV."
    )
    table_file: str | None = table_option("the cycle over time, or the days of the weather record")
    table_years: str | None = table_option(
        "the years of the weather record, a row a year", "--table-years", older="--csv-years"
    )
    plot_file: str | None = plot_option("Draw the cycle, or the weather record")
    figure: FigureOptions = figure_options()

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.weather_file is None:
            if self.table_years is not None:
                raise click.UsageError(
                    "--table-years needs --weather: years are those of a weather record"
                )
            return
        self.place.refuse_with_weather()


analyse = Command(
    "analyse",
    Analyse,
    "analyse:analyse",
    "solar-uav analyse atlantiksolar-as2 --latitude 47.6 --date 10-15",
)
