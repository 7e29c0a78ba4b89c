"""Options that several commands of ``solar-uav`` share; light, for help texts import this alone."""

from __future__ import annotations

import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import click

from sizing.program.objectives import RESIZE_NAMES
from solar.names import CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from studies.cli.command import CommandOptions, argument, option
from studies.cli.start import let_dask_in
from studies.cli.telling import progress_of, tell_error
from studies.cli.values import OutputFile, OutputFolder, Parsed, RealRange, latitude_deg
from studies.output import formats
from studies.output.figures.options import SHIPPED_STYLES, FigureOptions

if TYPE_CHECKING:
    from studies.engine.run import Study
    from studies.output.gridded import Gridded

EXIT_FAILED, EXIT_BAD_INPUT = 1, 2

_MAXIMUM_WORKERS = 1000


def mission_option(default: str | None) -> Any:
    """Return option ``--mission``; without a default a folder of results may stand in for it."""
    needed = "" if default else "  [required, unless AIRCRAFT is a folder that --out wrote]"
    text = f"Name or file.{needed}"
    return option(text, "-m", default=default, type=click.Path(), metavar="TEXT")


class Case(CommandOptions):
    """What a command is asked about: an aircraft on a mission."""

    has_case = True
    aircraft: str = argument(required=True, type=click.Path(), metavar="AIRCRAFT")
    mission: str | None = mission_option("rafz-july")
    overrides: tuple[str, ...] = option(
        "Override a key of the aircraft file, e.g. power.avionics_w=8 or wingspan_m=5, or of "
        "the mission with the prefix 'mission.', e.g. mission.clearness=0.8. May be repeated.",
        "--set",
        metavar="KEY=VALUE",
    )

    # Where they can be chosen.
    model: ModelName = "CAM"
    correction: CorrectionName = "none"
    mass_kg: float | None = None
    latitude: float | None = None
    day_of_year: int | None = None
    date: int | None = None
    required_h: float | None = None


class Model(Case):
    """A case whose solar power model can be chosen."""

    model: ModelName = option(
        "Solar power model. CDM and CAM: horizontal modules; VM and FM: the aircraft's "
        "module surfaces on the mission's flight path.",
        type=click.Choice(MODEL_NAMES, case_sensitive=False),
        default="CAM",
    )
    correction: CorrectionName = option(
        "Correction of the model's systematic error: none; report, as one flight measured "
        "it; loiter, from FM on the mission's flight path.",
        type=click.Choice(CORRECTION_NAMES),
        default="none",
    )


class Json(Case):
    """A case whose result may be printed as JSON."""

    as_json: bool = option("Print JSON instead of tables.")


class Level(Json):
    """A case of whose result a summary is printed, or all of it."""

    verbose: bool = option("Print all of the result, not a summary.", "-v")


class Mass(Case):
    """A case whose total mass may be known."""

    mass_kg: float | None = option(
        "Total mass with payload, where it is known: what the parts do not account for is "
        "other mass.",
        type=RealRange(0.0, 1e5, unit="kilograms", above=True),
        metavar="KG",
    )


class Place(Case):
    """Where and when instead of the mission's own; days of the year."""

    latitude: float | None = option(
        "Latitude, -90 to 90 (north) or as 33.9S, instead of the mission's.",
        type=Parsed("deg", latitude_deg),
    )
    day_of_year: int | None = option("Day instead of the mission's.", type=click.IntRange(1, 365))
    date: int | None = option(
        "Date instead of the mission's, e.g. 10-15 or 15 Oct.",
        type=Parsed("mm-dd", "missions.dates:day_of_year"),
    )

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.day_of_year is not None and self.date is not None:
            raise click.UsageError("give --day-of-year or --date, not both")

    def refuse_with_weather(self) -> None:
        """Refuse a place or a day beside that of a weather record."""
        if self.latitude is not None:
            raise click.UsageError(
                "a weather record has its own place: give --latitude or --weather"
            )
        for name, day in (("--date", self.date), ("--day-of-year", self.day_of_year)):
            if day is not None:
                text = f"a weather record has its own days: give {name} or --weather"
                raise click.UsageError(text)


class Requirement(Case):
    """A case whose required excess time can be chosen."""

    required_h: float | None = option(
        "Excess time that every scenario must have, instead of the mission's.",
        "--required-excess-time",
        type=RealRange(0.0, 1000.0, unit="hours"),
    )


class Work(CommandOptions):
    """Where a command computes in chunks, and what it keeps of them.

    ``module``: of the function that workers call.
    """

    module: ClassVar[str]
    out_file: str | None
    workers: int | None = option(
        "Processes that compute; 1 starts none.  [default: as many as there are cores, "
        "where the work is worth their start]",
        type=click.IntRange(1, _MAXIMUM_WORKERS),
    )
    scheduler: str | None = option(
        "Compute on a dask cluster: tcp://HOST:PORT, or local-cluster for one of this machine.",
        metavar="ADDRESS",
    )
    work_dir: str | None = option(
        "Folder for finished chunks.  [default: the name of --out with .parts]",
        type=click.Path(),
    )
    keep_parts: bool = option("Keep the finished chunks when the result is written.")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.scheduler not in (None, "local-cluster"):
            if self.workers is not None:
                raise click.UsageError(
                    "--workers: the scheduler's workers are those that were started for it; "
                    "allowed with --scheduler local-cluster"
                )
            if "://" not in str(self.scheduler):
                raise click.BadParameter(
                    f"must be tcp://HOST:PORT or local-cluster (got {self.scheduler!r})",
                    param_hint="--scheduler",
                )
        if self.keep_parts and self.work_dir is None and self.out_file is None:
            raise click.UsageError("--keep-parts needs --out or --work")
        if (self.workers or 1) > 1 and not self.scheduler:
            from studies.engine.workers import fork_from

            fork_from(self.module)  # while this process imports the same

    @contextmanager
    def completed(self, study: Study) -> Iterator[Gridded]:
        """Compute a study; inside the context its result is to be written and printed.

        After it the parts go. A signal ends the command with 128 plus its number and the way to go
        on; so does a disk that fills up, as an error. Where cells failed, standard error says so
        before and after the result, and the command ends with exit code 1; where all of them did
        there is no result.
        """
        from missions.files.writing import OutputError  # not for help
        from studies.engine.chunk_store import ChunkStore
        from studies.engine.workers import WorkersUnavailableError
        from studies.signals import Stopped

        job, store = study.job, None
        folder = None if self.out_file is None else parts_folder(self.out_file)
        if self.work_dir is not None:
            folder = Path(self.work_dir)

        def kept() -> str:
            if store is None:
                return "nothing is kept (--out or --work would keep what is finished)"
            keys = job.keys()
            count = sum(store.path(key).is_file() for key in keys)
            command = shlex.join(["solar-uav", *sys.argv[1:]])
            finished = f"{count} of {len(job.chunks)} chunks are kept in {store.folder}"
            return f"{finished}; to go on:\n  {command}"

        with ExitStack() as stack:
            if folder is not None:
                opened = ChunkStore(folder).opened(job.size_bytes, len(job.chunks))
                store = stack.enter_context(opened)
            try:
                if self.scheduler is not None:
                    let_dask_in()
                with progress_of(study.unit) as progress:
                    data, trouble = study.run(
                        self.workers,
                        self.scheduler,
                        store=store,
                        progress=progress,
                        tell=lambda text: tell_error(f"solar-uav: {text}"),
                    )
                if trouble:
                    tell_error(f"solar-uav: {trouble}")
                if data is None:
                    sys.exit(EXIT_FAILED)
                yield data
            except KeyboardInterrupt as stopped:
                number = stopped.signum if isinstance(stopped, Stopped) else signal.SIGINT
                tell_error(f"stopped; {kept()}")
                sys.exit(128 + number)
            except (OutputError, WorkersUnavailableError) as error:
                tell_error(f"solar-uav: {error}; {kept()}")
                sys.exit(EXIT_FAILED)
            if store is not None and not self.keep_parts and not trouble:
                store.remove_parts(job.keys())
        if trouble:
            tell_error(f"solar-uav: the result is not complete: {trouble}")
            sys.exit(EXIT_FAILED)


def parts_folder(target: str) -> Path | None:
    """Return the folder for the parts of a result file; None for a device or a pipe."""
    path = Path(target)
    return path.with_name(f"{path.name}.parts") if path.is_file() or not path.exists() else None


def resize(text: str, name: str = "--resize", **settings: Any) -> Any:
    """Return the option of an objective that cells and points are sized for."""
    return option(text, name, type=click.Choice(RESIZE_NAMES), **settings)


def out(contents: str) -> Any:
    """Return option ``--out`` of commands that write a folder."""
    text = f"Folder for aircraft, mission, results and {contents}; see docs/cli.md."
    return option(text, type=OutputFolder())


def _written(text: str, *spelled: str, kind: OutputFile, **settings: Any) -> Any:
    """Return the option of a file whose format its name tells."""
    return option(f"{text} ({', '.join(kind.formats)}).", *spelled, type=kind, **settings)


def table(contents: str, name: str = "--table", *, older: str = "--csv") -> Any:
    """Return option ``--table FILE`` of commands that write a table.

    ``older``: what the option was called when CSV was all that it wrote.
    """
    kind = OutputFile(*formats.TABLE_FORMATS, without_ending=formats.PLAIN_TABLE)
    return _written(f"Write {contents}", name, older, kind=kind, metavar="FILE")


def grid(contents: str) -> Any:
    """Return option ``--out FILE`` of commands whose result lies on a grid."""
    return _written(f"Write {contents}", kind=OutputFile(*formats.GRID_FORMATS))


def plot(text: str) -> Any:
    """Return option ``--plot FILE`` of commands that draw."""
    return _written(text, kind=OutputFile(*formats.IMAGE_FORMATS))


def file(text: str, **settings: Any) -> Any:
    """Return the option of a file, or of what stands for one."""
    return option(text, type=click.Path(), metavar="FILE", **settings)


def report() -> Any:
    """Return option ``--report`` of commands whose results a page may show."""
    return file("Also write a report, .html or .pdf; see docs/report.md.")


class Drawn(CommandOptions):
    """How figures of a command look, refused where none is asked for: it draws on request."""

    size_in: tuple[float, float | None] | None = option(
        "For example 170x100mm or 7x4in; a width alone, 85mm, leaves the height to the figure.",
        "--figure-size",
        type=Parsed("size", "studies.output.figures.options:read_size"),
        metavar="WIDTHxHEIGHT",
    )
    dots_per_inch: float | None = option(
        "Dots per inch of PNG.  [default: 150]",
        "--dpi",
        type=Parsed("dots", "studies.output.figures.options:read_dots_per_inch"),
    )
    style: str | None = option(
        f"Type, lines and colours: {', '.join(SHIPPED_STYLES)}, a style of matplotlib, or "
        "an .mplstyle file.  [default: default]",
        type=Parsed("name|file", "studies.output.figures.drawing:read_style"),
    )
    no_title: bool = option("Leave title and notes to the caption.")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        command = click.get_current_context()
        spelled = {str(parameter.name): parameter.opts[0] for parameter in command.command.params}
        places = [name for name in ("plot_file", "out_dir") if name in spelled]
        looks = ("size_in", "dots_per_inch", "style", "no_title")
        named = [name for name in looks if getattr(self, name) not in (None, False)]
        if not named:
            return
        if all(getattr(self, name) is None for name in places):
            draws = " or ".join(spelled[name] for name in places)
            raise click.UsageError(f"{spelled[named[0]]} is of the figure: give {draws} too")
        try:
            _ = self.figure
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    @cached_property
    def figure(self) -> FigureOptions:
        """How figures look."""
        style = {} if self.style is None else {"style": self.style}
        return FigureOptions(self.size_in, self.dots_per_inch, title=not self.no_title, **style)
