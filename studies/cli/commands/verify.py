"""Commands to verify with: ``solar-uav compare``, ``verify`` and ``reproduce-report``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from studies.cli import options
from studies.cli.command import argument, command, option
from studies.cli.values import Parsed, RealRange, names_of

if TYPE_CHECKING:
    import datetime

    from missions.logs.clock import Span
    from studies.case import Case
    from studies.cli.outputs import Folder
    from studies.flight_logs.errors import Window

_LONGEST_FILTER_S = 86_400.0
_YAML, _LOGS = (".yaml", ".yml"), (".csv", ".ulg", ".bin")
_SAMPLES = "samples.csv"  # file of a folder of results


@command(
    "All solar power models side by side.",
    "solar-uav compare atlantiksolar-design --objective min_mass --table models.csv",
)
class Compare(options.Level, options.Requirement, options.Drawn):
    """Compare what the solar power models say of AIRCRAFT, and what each would have built."""

    models: tuple[ModelName, ...] | None = option(
        f"Models to compare.  [default: {','.join(MODEL_NAMES)}]",
        type=names_of(MODEL_NAMES),
        metavar="M,M,...",
    )
    corrections: tuple[CorrectionName, ...] | None = option(
        f"Corrections to compare.  [default: {','.join(CORRECTION_NAMES)}]",
        type=names_of(CORRECTION_NAMES),
        metavar="C,C,...",
    )
    objective: str = options.resize(
        "What a parametric aircraft is sized for with every model.",
        "--objective",
        default="min_wingspan",
    )
    no_design: bool = option("Compare predictions only, size nothing.")
    out_dir: str | None = options.out("figure")
    table_file: str | None = options.table("the table")
    plot_file: str | None = options.plot("Draw the figure")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        files = (self.table_file, self.plot_file)
        if self.out_dir is not None and files != (None, None):
            raise click.UsageError("give --out, or --table and --plot, not both")

    def run(self, case: Case) -> None:
        """Run all solar power models, and tell what each says."""
        from studies.cli.outputs import deliver, figure_of
        from studies.cli.telling import progress_of
        from studies.models.comparison import compare
        from studies.models.solar_models import attitude_is_known
        from studies.output.formats import csv_bytes

        case.flyable().refuse_polar_night()
        paths = [f"--models {model}" for model in self.models or () if model in ATTITUDE_MODELS]
        paths += ["--corrections loiter"] if "loiter" in (self.corrections or ()) else []
        if paths or attitude_is_known(case.aircraft, case.mission):
            # With surfaces and a path, the reference flies it even if no case does.
            case.require_path([*paths, "the reference"][0])
        with progress_of("models", lines=False) as progress:
            compared = compare(
                case.aircraft,
                case.mission,
                models=self.models,
                corrections=self.corrections,
                objective=self.objective,
                design=not self.no_design,
                progress=progress,
            )
        plot = ("studies.models.plots:plot_comparison", compared)

        def folder() -> Folder:
            table = csv_bytes(compared.to_frame())
            drawn = figure_of(*plot, figure=self.figure)
            return case.inputs(), {"comparison.csv": table}, {"comparison.png": drawn}

        table = ("models", compared.to_frame)
        deliver(case, self, compared, table=table, plot=plot, folder=folder)
        sized = [of_model.built for of_model in compared.cases if of_model.built is not None]
        if sized and all(built.judged is None for built in sized):
            sys.exit(options.EXIT_FAILED)


@command(
    "The solar power models against a flight log.",
    "solar-uav verify atlantiksolar-as2 flight.csv --window 5.71:5.79 --out verified",
)
class Verify(options.Level, options.Drawn):
    """Compare the solar power models with the flight LOG (table, ULog, DataFlash) of AIRCRAFT."""

    log_file: str = argument(metavar="LOG", type=click.Path())
    columns_file: str | None = options.file(
        "YAML that says which column is what; what it does not say is guessed.",
    )
    columns: tuple[tuple[str, str], ...] = option(
        "Column of the log, e.g. 'solar_power_w=P [kW]' or 'solar_power_w=U * I [mA]'. "
        "May be repeated.",
        "--column",
        type=Parsed("quantity=column", "missions.logs.columns:parse_column"),
    )
    timezone: datetime.tzinfo | None = option(
        "Zone of times that are written without one: UTC, +02:00 or Europe/Zurich.",
        type=Parsed("zone", "missions.logs.clock:parse_zone"),
    )
    start: float | None = option(
        "Time of the first row with its zone, where times count from there.",
        type=Parsed("time", "missions.logs.clock:parse_instant"),
    )
    exclude: tuple[Span, ...] = option(
        "Times of day to leave out, e.g. 11:20-11:45, or 2015-07-01@11:20-11:45 of one "
        "day; by the clock of --timezone, else UTC. May be repeated.",
        type=Parsed("times", "missions.logs.clock:parse_span"),
    )
    ignore: tuple[str, ...] = option(
        "Column or quantity of the log that is not used. May be repeated.",
        type=Parsed("name", "missions.logs.columns:column_name"),
    )
    mission: str | None = options.mission_option("rafz-28h")
    windows: tuple[Window, ...] = option(
        "Period in solar hours, e.g. 5.71:5.79, on every day, or 2015-07-01@5.71:5.79 on one. "
        "May be repeated.",
        "--window",
        type=Parsed("a:b", "studies.flight_logs.errors:parse_window"),
    )
    filter_s: float | None = option(
        "Time to either side in the moving average.  [default: 1 s in windows, 400 s over days]",
        type=RealRange(0.0, _LONGEST_FILTER_S, unit="seconds"),
    )
    clock_offset_min: float = option(
        "Time that the log's clock is ahead of universal time, which is taken off.",
        type=RealRange(-1440.0, 1440.0, unit="minutes"),
        default=0.0,
        show_default=False,
    )
    heading_offset_deg: float = option(
        "Angle that the log's yaw is too large, which is taken off.",
        type=RealRange(-360.0, 360.0, unit="degrees"),
        default=0.0,
        show_default=False,
    )
    out_dir: str | None = options.out("samples and figures")
    report_file: str | None = options.report()

    def refuse(self) -> None:
        """Refuse a log in place of an aircraft."""
        from missions.files.shipped import shipped_names  # not for help

        aircraft, log = self.aircraft, self.log_file
        named = log in shipped_names("aircraft") and not Path(log).exists()
        if aircraft.lower().endswith(_LOGS) and (named or log.lower().endswith(_YAML)):
            raise click.UsageError(f"the aircraft comes first: verify {log} {aircraft}")

    def run(self, case: Case) -> None:
        """Compare the models with a flight, write what was found, and tell it."""
        from missions.logs.columns import ColumnMap, read_column_map
        from missions.logs.csv import read_flight_log
        from studies.cli.outputs import check_report, deliver, figure_of, refuse_to_overwrite
        from studies.flight_logs.verification import verify

        log_file = self.log_file
        if self.out_dir is not None:
            refuse_to_overwrite("--out", str(Path(self.out_dir) / _SAMPLES), log_file)
        check_report(self.report_file, option="--report")
        columns = self.columns_file
        layout = ColumnMap() if columns is None else read_column_map(columns)
        said = (self.timezone, self.start, self.ignore, self.exclude)
        result = verify(
            case.aircraft,
            read_flight_log(log_file, layout.with_options(dict(self.columns), *said)),
            case.mission,
            windows=self.windows,
            filter_s=self.filter_s,
            clock_offset_min=self.clock_offset_min,
            heading_offset_deg=self.heading_offset_deg,
        )

        def folder() -> Folder:
            from studies.flight_logs.plots import figures

            drawn = figures(result, figure=self.figure)
            pictures = {f"{name}.png": figure_of(draw) for name, draw in drawn}
            return case.inputs(log=Path(log_file)), {_SAMPLES: result.to_csv().encode()}, pictures

        def report() -> dict[str, Any]:
            inputs = case.inputs(log=Path(log_file))
            return {"inputs": inputs, "verification": result, "overrides": self.overrides}

        deliver(case, self, result, folder=folder, report=report)


@command(
    "The four models on the morning they were published with.",
    "solar-uav reproduce-report --out reproduced",
)
class ReproduceReport(options.Drawn):
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """

    as_json: bool = option("Print JSON.")
    out_dir: str | None = options.out("figure and table")

    def run(self) -> None:
        """Fly the morning of the report with all four models."""
        from studies.case import Case
        from studies.cli.files import opened
        from studies.cli.outputs import deliver, figure_of
        from studies.models import report_reproduction as study

        case = Case(opened("aircraft", study.AIRCRAFT), opened("mission", study.MISSION))
        result = study.reproduce(case.aircraft, case.mission, vary=True)

        def folder() -> Folder:
            tables = "\n".join(table.to_markdown() for table in result.tables())
            drawing = figure_of(study.reproduction_figure, result, figure=self.figure)
            return case.inputs(), {"report.md": tables.encode()}, {"report.png": drawing}

        deliver(case, self, result, folder=folder)
