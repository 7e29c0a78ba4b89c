"""The commands ``solar-uav fit`` and ``calibrate``."""

from __future__ import annotations

from dataclasses import dataclass

from studies.cli.command import Command, RealRange, argument, completes, option
from studies.cli.options import (
    CaseOptions,
    LogOptions,
    aircraft_argument,
    case_options,
    figure_options,
    json_option,
    log_options,
    out_option,
    write_option,
)
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class Fit:
    """Fit parameters of AIRCRAFT to one or several flights, with confidence intervals."""

    case: CaseOptions = case_options(mission="rafz-28h", with_models=False)
    log: LogOptions = log_options()
    more_logs: tuple[str, ...] = argument(metavar="[LOG]...", nargs=-1)
    names: tuple[str, ...] = option(
        "--fit",
        metavar="NAME",
        multiple=True,
        help="Parameter to fit, e.g. temperature_rise; see docs/fit.md. May be repeated.  "
        "[default: module_efficiency, temperature_rise, the level power, specific_energy]",
    )
    light_sigma: float = option(
        "--light-sigma",
        type=RealRange(0.0, 0.5, unit="a share"),
        default=0.03,
        show_default=True,
        help="Standard uncertainty of the level of the clear sky's light, relative.",
    )
    other_log: str | None = option(
        "--predict", metavar="LOG", help="Another flight, whose charge is predicted from the fit."
    )
    write_file: str | None = write_option(
        "Write the fitted aircraft, with where its numbers come from."
    )
    out_dir: str | None = out_option("a figure")
    figure: FigureOptions = figure_options()


@dataclass(frozen=True)
class Calibrate:
    """Make a parametric aircraft of a measured AIRCRAFT and the models of TECHNOLOGY."""

    aircraft: str = aircraft_argument()
    technology: str = argument(shell_complete=completes("aircraft"))
    overrides: tuple[str, ...] = option(
        "--set",
        metavar="KEY=VALUE",
        multiple=True,
        help="Override a key of TECHNOLOGY, e.g. airframe.avionics_mass_kg=0.3. May be repeated.",
    )
    write_file: str | None = write_option("Write the file.")
    as_json: bool = json_option()


fit = Command("fit", Fit, "fit:fit", "solar-uav fit atlantiksolar-as2 flight.csv --write mine.yaml")
calibrate = Command(
    "calibrate",
    Calibrate,
    "fit:calibrate",
    "solar-uav calibrate atlantiksolar-as2 atlantiksolar-design --write mine.yaml",
)
