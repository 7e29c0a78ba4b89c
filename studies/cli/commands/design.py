"""Commands to design with: ``solar-uav size``, ``sweep``, ``explore`` and ``export``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import click

from sizing.program.objectives import OBJECTIVE_NAMES, Objective
from studies.cli import options
from studies.cli.command import check_outputs, command, option
from studies.cli.values import Parsed, RealRange

if TYPE_CHECKING:
    from sizing.results.sizing_study import SizingStudy
    from studies.case import Case
    from studies.cli.outputs import Folder
    from studies.engine.run import Study
    from studies.sweeps.axes import Axis, SampleName

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_MOST_SCENARIOS = 12  # VM and FM take some 10 ms for each
_SERVER = ("starlette", "uvicorn")  # of the extra ``explore``


def _renamed(_: click.Context, option: click.Parameter, given: bool) -> None:
    if given:
        raise click.UsageError(f"{option.opts[0]} is called --cross-check now")


@command(
    "The best design for a mission.",
    "solar-uav size atlantiksolar-design -m rafz-july --required-excess-time 2",
    "solar-uav size atlantiksolar-design -m mission.yaml --weather FILE --survive 0.9",
)
class Size(
    options.Model, options.Level, options.Mass, options.Place, options.Requirement, options.Drawn
):
    """Find the best design of AIRCRAFT (name, file or folder) for a mission."""

    mission: str | None = options.mission_option(None)
    objective: str = option(
        "Masses and wingspan become as small as the mission's required excess "
        "time allows; max_excess_time ends at the bounds of the design space; longest_season and "
        "widest_latitude_band search for the most days, or degrees of latitude, in which one "
        "design flies perpetually, max_endurance for the longest flight.",
        type=click.Choice(OBJECTIVE_NAMES),
        default="min_mass",
    )
    out_dir: str | None = options.out("figures")
    report_file: str | None = options.report()
    with_sensitivities: bool = option(
        "Tell how the optimum changes with each technology parameter."
    )
    certify: bool = option("", hidden=True, callback=_renamed)
    with_cross_check: bool = option(
        "Try to beat the optimum with 400 other designs in the simulator."
    )
    whole_cells: bool = option(
        "Round the optimum to whole solar and battery cells, search the designs next to it "
        "and print the loss; for files with modules.layout and battery.pack."
    )
    reliability: float | None = option(
        "Least probability of the required excess time in every scenario when the uncertain "
        "inputs of aircraft and mission scatter, for instance 0.95.",
        type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True, below=True),
        metavar="PROBABILITY",
    )
    hold_station: float | None = option(
        "Fly as fast as this percentile of the wind of each latitude and month, for instance "
        "95: it holds its place for at least that share of the time. Short for the mission's "
        "wind: {percentile: 95, hold_station: true}. The shipped table of winds has the 95th "
        "alone; others come from a file of the mission's wind.",
        type=RealRange(0.0, 100.0, unit="the interval from 0 to 100", above=True, below=True),
        metavar="PERCENTILE",
    )
    weather_file: str | None = options.file(
        "Size for the days of a weather record on the mission's dates, instead of clear ones; "
        "with --survive."
    )
    survive: float | None = option(
        "Least share of the days of the weather record that close, for instance 0.9.",
        type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True),
        metavar="SHARE",
    )

    def refuse(self) -> None:
        """Refuse what does not go together."""
        of_optimum = self.with_sensitivities or self.with_cross_check
        if self.goal.of_range and of_optimum:
            raise click.UsageError(
                f"{self.objective} counts days or degrees: it has no sensitivities and no "
                "cross-check"
            )
        of_clear_days = {
            "--sensitivities": self.with_sensitivities,
            "--cross-check": self.with_cross_check,
            "--reliability": self.reliability is not None,
        }
        if self.whole_cells:
            others = {
                f"--objective {self.objective}": self.goal.of_range,
                **of_clear_days,
                "--survive": self.survive is not None,
            }
            _refuse_given(others, "--whole-cells does not go with {}")
        if self.reliability is not None and of_optimum:
            raise click.UsageError("--sensitivities and --cross-check know of no --reliability")
        if (self.weather_file is None) != (self.survive is None):
            names = ("--weather", "--survive")
            present, other = names if self.survive is None else names[::-1]
            raise click.UsageError(f"{present} needs {other} as well")
        if self.survive is not None:
            self.refuse_with_weather()
            if self.report_file is not None:
                raise click.UsageError(
                    "--report is of repeated clear days: use --out FOLDER, then solar-uav report "
                    "FOLDER --weather FILE"
                )
            _refuse_given(
                of_clear_days | {"--required-excess-time": self.required_h is not None},
                "{} is of repeated clear days: leave it out, or --weather with --survive",
            )

    @property
    def goal(self) -> Objective:
        """Objective of the optimiser."""
        return Objective(self.objective)

    def run(self, case: Case) -> None:
        """Find the best design, write it, and tell it."""
        from missions.mission import Mission
        from sizing.program.reliability import check_reliability
        from sizing.program.survival import check_survival
        from studies.cli.files import uncertain_inputs
        from studies.cli.outputs import check_report, deliver, figure_of
        from studies.output.sizing_files import sized_inputs, sizing_figures, sizing_tables

        if self.survive is not None:
            try:
                check_survival(self.goal, self.survive)
            except ValueError as error:
                raise click.UsageError(str(error)) from error
        if self.hold_station is not None:
            wind = case.mission_file.document.data.get("wind")
            file = {"file": wind["file"]} if isinstance(wind, dict) and "file" in wind else {}
            held = {"percentile": self.hold_station, "hold_station": True, **file}
            case = case.with_mission(wind=held)
        case.require_parametric("a measured aircraft cannot be sized; allowed: parametric")
        case.flyable(sized=True)
        if not self.goal.of_range and self.weather_file is None:
            case.refuse_polar_night()
        modules, battery = case.aircraft.modules, case.aircraft.battery
        cells = {"modules.layout": modules.layout, "battery.pack": battery.pack}
        for key, value in cells.items():
            if self.whole_cells and value is None:
                case.refuse(key, "required key is missing: --whole-cells needs it")
        if self.reliability is not None:
            with uncertain_inputs(case):
                check_reliability(
                    case.aircraft, case.mission, self.goal, case.solar, self.reliability
                )
        check_report(self.report_file, option="--report")
        study = self._designed(case)

        def folder() -> Folder:
            inputs = sized_inputs(study, case.inputs(self.weather_file))
            drawn = sizing_figures(study, self.figure)
            figures = {name: figure_of(draw) for name, draw in drawn.items()}
            return inputs, sizing_tables(study), figures

        def report() -> dict[str, Any]:
            inputs = sized_inputs(study, case.inputs())
            mission = Mission.model_validate(inputs.mission)  # that it was sized for
            sized = replace(
                case,
                aircraft_file=replace(case.aircraft_file, record=study.sized_aircraft()),
                mission_file=replace(case.mission_file, record=mission),
            )
            about = {"sizing": case.named(study.to_dict()), "overrides": self.overrides}
            return {"sized": sized, "inputs": inputs, **about}

        deliver(
            case,
            self,
            study,
            folder=folder if study.feasible else None,
            report=report if study.feasible else None,
            remarks=lambda: self._remarks(study),
            next_step=self._next_step(study),
        )
        if not study.feasible:
            sys.exit(options.EXIT_FAILED)

    def _designed(self, case: Case) -> SizingStudy:
        """Find the design."""
        from missions.weather.files import load_weather
        from sizing.results import sizing
        from sizing.results.sizing import size_in_weather
        from studies.cli.telling import progress_of

        if self.weather_file is None or self.survive is None:
            return sizing.size(
                **case.arguments,
                objective=self.goal,
                with_sensitivities=self.with_sensitivities,
                with_cross_check=self.with_cross_check,
                with_margin=not self.whole_cells,
                with_builds=True,
                whole_cells=self.whole_cells,
                reliability=self.reliability,
            )
        weather = load_weather(self.weather_file, case.mission)
        with progress_of("steps of the search") as progress:
            return size_in_weather(
                **case.arguments,
                weather=weather,
                objective=self.goal,
                survive=self.survive,
                progress=progress,
            )

    def _remarks(self, study: SizingStudy) -> list[str]:
        """Return what all solar power models say of the optimum."""
        from sizing.day.module_power import path_troubles
        from studies.models.solar_models import perpetual_by_model, perpetual_line

        if not study.feasible or self.weather_file is not None:
            return []
        aircraft, mission = study.sized_aircraft(), study.sized_mission()
        blown = path_troubles(aircraft, mission)[0] is not None
        if blown or len(mission.scenarios()) > _MOST_SCENARIOS:
            return []
        line = perpetual_line(list(perpetual_by_model(aircraft, mission).values()), mission)
        return [f"the sized design with all solar power models: {line}"]

    def _next_step(self, study: SizingStudy) -> str:
        """Return what to do after a sizing."""
        if study.feasible and self.out_dir is not None:
            import shlex

            folder = shlex.quote(self.out_dir)
            return f"solar-uav report {folder} --out report.html; solar-uav analyse {folder}"
        if study.feasible:
            return "the same with --out FOLDER keeps the design, for analyse, map and report"
        if eased := study.relaxations:
            from solar.schema import spell

            to = f"{eased[0].parameter}={spell(eased[0].value)}"
            return f"the same with --set {to}, or another of these"
        return "ease what holds it back; docs/sizing-answers.md, Infeasible, says how to read it"


def _refuse_given(given: Mapping[str, bool], why: str) -> None:
    """Refuse the first of some options that is given; its name stands for the braces."""
    for name, is_set in given.items():
        if is_set:
            raise click.UsageError(why.format(name))


@command(
    "Trade study: vary keys, judge or size.",
    "solar-uav sweep atlantiksolar-design --vary battery_mass_kg=2:4:0.5",
)
class Sweep(options.Model, options.Level, options.Mass, options.Work, options.Drawn):
    """Trade study: vary keys of AIRCRAFT (name, file or folder) and mission, each point judged.

    The exit code is 1 if any point could not be computed.
    """

    axes: tuple[Axis, ...] = option(
        "KEY=first:last:step (last is met where the steps lead to it) or KEY=v1,v2,...; a key "
        "as of --set, or wingspan_m, aspect_ratio, battery_mass_kg, module_area_m2. May be "
        "repeated.",
        "--vary",
        type=Parsed("key=values", "studies.sweeps.axes:parse_axis", stepped=float),
        required=True,
    )
    objective: str | None = options.resize(
        "Size each point for it; varied design variables are held."
    )
    module = "studies.sweeps.study"
    cover: bool | None = option(
        "Fill the wing with modules, to maximum_module_coverage.  [default: where a "
        "parametric wing is varied and the module area is not]",
        "--cover/--no-cover",
        default=None,
    )
    sample: SampleName = option(
        "All combinations; points drawn between least and largest values; or one key at a time.",
        type=click.Choice(_SAMPLES),
        default="grid",
    )
    samples: int = option(
        "Number of points that lhs and sobol draw.",
        type=click.IntRange(1, _MOST_SAMPLES),
        default=64,
    )
    seed: int = option("For drawing.", type=click.IntRange(0), default=0)
    out_file: str | None = options.grid("all points")
    plot_file: str | None = options.plot("Draw the study")
    pareto: tuple[str, str] | None = option(
        "Only the front of two results or varied keys, e.g. wingspan payload_mass: the points "
        "for which no other is better in both.",
        nargs=2,
        metavar="X Y",
    )
    sort: str | None = option(
        "Sort the table by a result or varied key, the least first; by -KEY the largest "
        "first.  [default: from best to worst]",
        metavar="KEY",
    )
    top: int | None = option(
        "Rows of the table.  [default: 15, with -v all]", type=click.IntRange(1), metavar="N"
    )

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.pareto is not None and self.sort is not None:
            raise click.UsageError("a front has its own order: give --pareto or --sort")

    def run(self, case: Case) -> None:
        """Compute the points of a trade study, write them, and tell them."""
        from missions.files.errors import InputError
        from studies.cli.outputs import call, deliver, grid_of
        from studies.cli.telling import tell_error
        from studies.sweeps.study import prepare

        case.flyable(sized=self.objective is not None)
        try:
            study = prepare(
                case.aircraft,
                case.mission,
                self.axes,
                case.solar,
                sample=self.sample,
                samples=self.samples,
                seed=self.seed,
                resize=self.objective,
                cover=self.cover,
                total_mass_kg=case.total_mass_kg,
            )
        except InputError as error:
            named = [replace(p, source=f"--vary {p.source}") for p in error.problems]
            raise InputError(named) from None
        self._check_shown(study)
        with self.completed(study) as points:
            from studies.sweeps.results import SweepResult  # pandas and xarray

            data = points.to_xarray()
            draw = "plot_sweep" if self.pareto is None else "plot_pareto"
            try:
                deliver(
                    case,
                    self,
                    SweepResult(data, self.sort, self.top, self.pareto),
                    files={self.out_file: grid_of(data, study.unit)},
                    plot=(f"studies.sweeps.plots:{draw}", data, *(self.pareto or ())),
                    next_step=f"{call('explore')} (the same with sliders)",
                )
            except ValueError as error:
                # The points are worth keeping even where there is nothing to draw.
                tell_error(f"solar-uav: no chart: {error}")
                sys.exit(options.EXIT_FAILED)

    def _check_shown(self, study: Study) -> None:
        """Refuse names that no result will have, before the work starts."""
        from studies.engine.run import VARIED, blanks_of

        varied = {n: c.values.dtype.kind for n, c in study.coordinates.items() if n != VARIED}
        numbers = [name for name, kind in varied.items() if kind == "f"]
        numbers += [
            n for n, blank in blanks_of(study.described).items() if isinstance(blank, float)
        ]
        every = ["status", *(name for name in varied if name not in numbers), *numbers]
        sort = () if self.sort is None else (self.sort.removeprefix("-"),)
        shown = {"--pareto": (self.pareto or (), numbers), "--sort": (sort, every)}
        for hint, (names, allowed) in shown.items():
            for name in names:
                if name not in allowed:
                    text = f"{name!r} is not one of {', '.join(dict.fromkeys(allowed))}"
                    raise click.BadParameter(text, param_hint=hint)


@command(
    "Sliders for a design, on a local page.",
    "solar-uav explore atlantiksolar-design -m central-europe-summer",
)
class Explore(options.Model):
    """Explore AIRCRAFT (name, file or folder) with sliders, on a page of this machine."""

    port: int = option(
        "Port on this machine; 0 for any that is free.", type=click.IntRange(0, 65535), default=0
    )
    no_browser: bool = option("Only print the address.")

    def refuse(self) -> None:
        """Refuse to start without what the page is served by."""
        missing = next((name for name in _SERVER if find_spec(name) is None), None)
        if missing is not None:
            raise click.UsageError(
                f"explore needs {missing}: pip install 'solar-uav-sizing[explore]'"
            )

    def run(self, case: Case) -> None:
        """Serve the page of a design."""
        from studies.cli.telling import tell_error
        from studies.explorer.session import Session

        mission = case.flyable().mission_file.document
        words = [self.aircraft, "-m", mission.source.removesuffix(" (shipped)")]
        words += [word for override in self.overrides for word in ("--set", override)]
        session = Session(case, command=words)
        from studies.explorer.serve import ADDRESS, bound_socket, serve  # of the extra

        try:
            listening = bound_socket(self.port)
        except OSError as error:
            reason = f"cannot listen on {ADDRESS}:{self.port}: {error.strerror}; try --port 0"
            tell_error(f"solar-uav: {reason}")
            sys.exit(options.EXIT_FAILED)

        def tell(address: str) -> None:
            click.echo(address)  # which flushes, so that a program that started us can read it
            tell_error(f"{case.title}; Ctrl-C ends it")

        serve(session, listening, tell=tell, browser=not self.no_browser)


@command(
    "A design for other tools, papers and sheets.",
    "solar-uav export atlantiksolar-design --out wing.avl",
    "solar-uav export sized -m rafz-july --out design.tex --out design.xlsx",
)
class Export(options.Model):
    """Write AIRCRAFT (name, file or folder) for other tools: its geometry, or its numbers."""

    out_files: tuple[str, ...] = options.file(
        "Write geometry: .avl (AVL), .vspscript (OpenVSP), .py (AeroSandbox); or a table of "
        "the design on its mission: .tex, .xlsx, .csv, .parquet. May be given several times.",
        required=True,
    )

    def run(self, case: Case) -> None:
        """Write a design for other tools: of several files those that can be written."""
        from missions.files.writing import write_bytes_atomically
        from sizing.results.analysis import analyse
        from studies.cli.telling import tell_error
        from studies.exchange import files
        from studies.output.formats import wrong_ending
        from studies.output.terminal import tell_line

        several, troubles = len(self.out_files) > 1, dict[str, Exception]()
        for path in self.out_files:
            try:
                check_outputs({"--out": path})
            except OSError as error:
                troubles[path] = error
            if files.design_format(path) is None:
                message = wrong_ending(path, files.DESIGN_FORMATS)
                raise click.BadParameter(message, param_hint="--out")
            missing = files.missing_for(path)
            if missing is not None:
                troubles[path] = click.BadParameter(missing, param_hint="--out")
        if len(troubles) == len(set(self.out_files)):
            raise next(iter(troubles.values()))
        analysis = analyse(**case.flyable().arguments, replay=False)
        for path in self.out_files:
            if path not in troubles:
                try:
                    write_bytes_atomically(path, files.design_bytes(analysis, path))
                    tell_line(f"written to {path}")
                except OSError as error:
                    if not several:
                        raise
                    troubles[path] = error
        for path, trouble in troubles.items():
            reason = trouble.message if isinstance(trouble, click.BadParameter) else str(trouble)
            tell_error(f"solar-uav: {path} is not written: {reason}")
        if troubles:
            sys.exit(options.EXIT_FAILED)
