"""Commands to analyse with: ``solar-uav analyse``, ``map``, ``ceiling``, ``station`` and others."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from studies.cli import options
from studies.cli.command import command, option
from studies.cli.values import RealRange, degrees, grid

if TYPE_CHECKING:
    from studies.case import Case

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0


@command(
    "How long it flies, there and then.",
    "solar-uav analyse atlantiksolar-as2 --latitude 47.6 --date 10-15",
)
class Analyse(options.Model, options.Level, options.Mass, options.Place, options.Drawn):
    """Analyse how long AIRCRAFT (name, file or folder) flies, there and then."""

    weather_file: str | None = options.file(
        "Fly through a weather record: EPW, TMY2, TMY3, PVGIS, SAM, BSRN, POWER, ERA5 or plain CSV."
    )
    table_file: str | None = options.table("the cycle over time, or the days of the weather record")
    table_years: str | None = options.table(
        "the years of the weather record, a row a year", "--table-years", older="--csv-years"
    )
    plot_file: str | None = options.plot("Draw the cycle, or the weather record")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.weather_file is None:
            if self.table_years is not None:
                raise click.UsageError(
                    "--table-years needs --weather: years are those of a weather record"
                )
            return
        self.refuse_with_weather()

    def run(self, case: Case) -> None:
        """Fly the mission, and tell what became of it."""
        from sizing.results import analysis
        from studies.cli.outputs import call, deliver, refuse_to_overwrite

        for name, path in (("--table", self.table_file), ("--table-years", self.table_years)):
            refuse_to_overwrite(name, path, self.weather_file)
        case.flyable()
        if self.weather_file is not None:
            self._run_in_weather(case, self.weather_file)
            return
        result = analysis.analyse(**case.arguments, known_mass_kg=case.total_mass_kg)
        verb, what = "map", "where and when else"
        if not result.is_perpetual:
            flies = "flies perpetually" if case.mission.flight is None else "lands with power left"
            what = f"where and when it {flies}"
            if case.aircraft.airframe.kind == "parametric":
                verb, what = "size", f"a design that {flies}"
        drawn = ("cycle", result) if result.flight is None else ("flight", result, result.flight)
        deliver(
            case,
            self,
            result,
            table=("cycle", result.trajectory),
            plot=(f"studies.output.cycle_plots:plot_{drawn[0]}", *drawn[1:]),
            next_step=f"{call(verb)} ({what})",
        )

    def _run_in_weather(self, case: Case, weather_file: str) -> None:
        """Fly the case through a weather record, and tell what became of it."""
        from missions.weather.files import load_weather
        from sizing.results.analysis import analyse
        from sizing.results.weather import analyse_weather
        from studies.cli.outputs import deliver, table_of

        weather = load_weather(weather_file, case.mission)
        if self.table_years is not None and weather.typical:
            raise click.UsageError("--table-years needs a record of years: this is a typical year")
        result = analyse_weather(
            **case.arguments, weather=weather, mission_chosen=not case.mission_is_default
        )

        def record() -> dict[str, Any]:
            clear_day = analyse(**case.arguments | {"mission": result.mission}, replay=False)
            return clear_day.to_dict() | {"weather": result.to_dict()}

        deliver(
            case,
            self,
            result,
            table=("days", result.to_frame),
            files={self.table_years: table_of("years", result.to_years_frame)},
            plot=("studies.weather:plot_weather", result),
            record=record,
        )


@command(
    "Where and when it flies perpetually.",
    "solar-uav map atlantiksolar-as2 --latitudes 0:70:5 --plot map.png",
)
class Map(options.Model, options.Level, options.Mass, options.Work, options.Drawn):
    """Map where and when AIRCRAFT (name, file or folder) flies perpetually.

    Latitude against season; of the mission the air and the load count, not its latitudes and
    dates. With --resize: which design flies there and then. The exit code is 1 if any cell could
    not be computed.
    """

    latitudes: list[float] | None = option(
        "Latitudes [deg], north positive; the last one is met where the steps lead to it. "
        "[default: -70:70:1; with --resize, --endurance, VM, FM, loiter and climb -70:70:2]",
        type=grid(-90.0, 90.0, read=degrees),
    )
    days: list[float] | None = option(
        "Days of the year, 1 to 365; the last one is met where the steps lead to it. "
        "[default: 1:365:1; where --latitudes has steps of 2 by itself 1:365:4]",
        type=grid(1.0, 365.0, whole=True),
    )
    module = "studies.maps.study"
    endurance: bool = option("Also the longest flight of each cell (slow); not with --resize.")
    objective: str | None = options.resize("Size the aircraft anew in every cell for it.")
    out_file: str | None = options.grid("all cells")
    plot_file: str | None = options.plot("Draw the map")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.objective is not None and self.endurance:
            raise click.UsageError("--endurance is of a fixed aircraft; not with --resize")

    def run(self, case: Case) -> None:
        """Compute the cells of a map, write it, and tell it."""
        from studies.cli.outputs import call, deliver, grid_of
        from studies.maps.results import MapResult
        from studies.maps.study import prepare

        sized = self.objective is not None
        case.flyable(sized=sized, in_winds_of_cells=True)
        if sized:
            case.require_parametric("--resize needs a parametric aircraft, this one is measured")
        study = prepare(
            case.aircraft,
            case.mission,
            self.latitudes,
            self.days,
            case.solar,
            endurance=self.endurance,
            objective=self.objective,
        )
        draw = "plot_resized_map" if sized else "plot_map"
        with self.completed(study) as data:
            deliver(
                case,
                self,
                MapResult(data),
                files={self.out_file: grid_of(data, "cells")},
                plot=(f"studies.maps.plots:{draw}", data),
                next_step=call("report", "--out", "report.html"),
            )


@command(
    "How high it flies perpetually.",
    "solar-uav ceiling atlantiksolar-as2 --plot ceiling.png",
)
class Ceiling(options.Model, options.Level, options.Drawn):
    """Find how high AIRCRAFT (name, file or folder) flies perpetually; exit code 1 if nowhere."""

    highest_m: float | None = option(
        "End of the search, which starts at the mission's altitude and goes down from there "
        "where nothing above is feasible; by default 20000, for missions above 15000 m 32000.",
        type=RealRange(-500.0, _HIGHEST_M, unit="metres"),
    )
    step_m: float = option(
        "Spacing of the altitudes that are tried.",
        type=RealRange(_LEAST_STEP_M, 10000.0, unit="metres"),
        default=250.0,
    )
    table_file: str | None = options.table("the altitudes")
    plot_file: str | None = options.plot("Draw them")

    def run(self, case: Case) -> None:
        """Find the highest altitude of perpetual flight, and tell it."""
        from solar.schema import refusal, spell
        from studies.ceiling import perpetual_ceiling
        from studies.cli.outputs import deliver
        from studies.cli.telling import progress_of

        case.flyable().refuse_polar_night()
        lowest_m, most_m = case.mission.altitude_m, case.mission.highest_floor_m
        if most_m <= lowest_m:
            message = f"must be above the night's floor of {spell(lowest_m)}"
            case.refuse("mission.climb.ceiling_m", refusal(message, most_m))
        if self.highest_m is not None and self.highest_m <= lowest_m:
            message = f"must be above the mission's altitude_m of {spell(lowest_m)}"
            raise click.BadParameter(refusal(message, self.highest_m), param_hint="--highest")
        with progress_of("altitudes", lines=False) as progress:
            result = perpetual_ceiling(
                **case.arguments, highest_m=self.highest_m, step_m=self.step_m, progress=progress
            )
        plot = ("studies.ceiling:plot_ceiling", result)
        deliver(case, self, result, table=("altitudes", result.to_frame), plot=plot)
        if result.search.highest is None:
            sys.exit(options.EXIT_FAILED)


@command(
    "How often it holds its place in the wind.",
    "solar-uav station my-aircraft.yaml -m my-mission.yaml --latitudes 0:60:5 --plot station.png",
)
class Station(options.Model, options.Level, options.Work, options.Drawn):
    """Tell how much of the time AIRCRAFT (name, file or folder) holds its place, by month.

    Latitude against month, altitude against month at the mission's latitude, or latitude against
    month at the best altitude. It flies as fast as the repeated
    day allows, and the wind is that of the mission's key wind.
    """

    latitudes: list[float] | None = option(
        "Latitudes [deg], north positive. [default: -70:70:5]",
        type=grid(-90.0, 90.0, read=degrees),
    )
    module = "studies.station"
    altitudes: list[float] | None = option(
        "Altitudes [m] in place of latitudes; with --latitudes too, that of the largest share "
        "is flown in each month.",
        type=grid(-500.0, 32000.0),
    )
    out_file: str | None = options.grid("all cells")
    plot_file: str | None = options.plot("Draw them")

    def run(self, case: Case) -> None:
        """Compute the time on station of each month, and tell it."""
        from studies.cli.outputs import deliver
        from studies.output.formats import GRID_FORMATS, format_of, table_bytes
        from studies.output.gridded import to_netcdf_bytes
        from studies.station import prepare

        if case.flyable().mission.climb is not None:
            why = "the percentiles of the winds at several heights have none in common"
            message = f"station flies at constant altitude, as {why}; remove climb"
            case.refuse("mission.climb", message)
        case.require_parametric("station needs a parametric aircraft, this one is measured")
        study, result_of = prepare(
            case.aircraft, case.mission, self.latitudes, self.altitudes, case.solar
        )
        with self.completed(study) as data:
            result = result_of(data)

            def content(path: str) -> bytes:
                if format_of(path, GRID_FORMATS) == "nc":
                    return to_netcdf_bytes(result.cells)
                return table_bytes(result.to_frame(), path)

            plot = ("studies.station:plot_station", result)
            deliver(case, self, result, files={self.out_file: content}, plot=plot)


@command(
    "How likely it flies perpetually when inputs scatter.",
    "solar-uav uncertainty atlantiksolar-as2 --samples 1024",
)
class Uncertainty(options.Model, options.Level, options.Drawn):
    """Find how likely AIRCRAFT (name, file or folder) flies perpetually when its inputs scatter."""

    samples: int = option(
        "Draws of all uncertain inputs, rounded up to a power of two.",
        type=click.IntRange(64, 2**20),
        default=8192,
    )
    seed: int = option(
        "The same seed gives the same draws.", type=click.IntRange(0, 2**31), default=0
    )
    no_model_error: bool = option(
        "Leave out the error of the solar power model, which is an input by itself."
    )
    table_file: str | None = options.table("the draws")
    plot_file: str | None = options.plot("Draw them")

    def run(self, case: Case) -> None:
        """Draw uncertain inputs, and tell what becomes of the flight."""
        from sizing.results.uncertainty import analyse_uncertainty
        from studies.cli.files import uncertain_inputs
        from studies.cli.outputs import deliver

        with uncertain_inputs(case.flyable()):
            result = analyse_uncertainty(
                **case.arguments,
                samples=self.samples,
                seed=self.seed,
                model_error=not self.no_model_error,
            )
        plot = ("studies.uncertainty:plot_uncertainty", result)
        deliver(case, self, result, table=("draws", result.to_frame), plot=plot)


@command(
    "A page on a design, to be read or printed.",
    "solar-uav report atlantiksolar-as2 -m rafz-july --out report.html",
)
class Report(options.Model, options.Json, options.Mass):
    """Write a report on AIRCRAFT (name, file or folder): one page, to be read or printed."""

    out_file: str = options.file(
        "Write the page: .html, or .pdf for the printed one alone.",
        required=True,
    )
    with_pdf: bool = option("Also print it, beside the page, as PDF.")
    project: str | None = option("Project, for the head.", metavar="TEXT")
    author: str | None = option("Author, for the head.", metavar="TEXT")
    weather_file: str | None = options.file("Also fly through a weather record, as analyse does.")
    uncertainty: bool | None = option(
        "Whether inputs scatter.  [default: if aircraft or mission has uncertain inputs]",
        "--uncertainty/--no-uncertainty",
        default=None,
    )

    def run(self, case: Case) -> None:
        """Write a report on an aircraft and a mission."""
        from missions.weather.files import load_weather
        from studies.cli.outputs import check_report, name_written, sizing_of_folder, write_report
        from studies.output.terminal import print_json

        check_report(self.out_file, with_pdf=self.with_pdf)
        case.flyable()
        weather = self.weather_file
        subject, written = write_report(
            case,
            self.out_file,
            with_pdf=self.with_pdf,
            sizing=sizing_of_folder(self.aircraft, case),
            overrides=self.overrides,
            with_uncertainty=self.uncertainty,
            weather_record=None if weather is None else load_weather(weather, case.mission),
            project=self.project or "",
            author=self.author or "",
        )
        if self.as_json:
            print_json(subject.results())
        else:
            name_written(written)
