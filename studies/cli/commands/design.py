"""Commands to design with: ``solar-uav size``, ``sweep``, ``explore`` and ``export``."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING

import click

from sizing.program.objectives import OBJECTIVE_NAMES, RESIZE_NAMES, Objective
from studies.cli.command import command, option
from studies.cli.options import (
    DrawnOptions,
    LevelOptions,
    MassOptions,
    ModelOptions,
    PlaceOptions,
    RequirementOptions,
    WorkOptions,
    grid_option,
    mission_option,
    out_option,
    plot_option,
    report_option,
    weather_option,
)
from studies.cli.values import Parsed, RealRange

if TYPE_CHECKING:
    from studies.sweeps.axes import Axis, SampleName

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_SERVER = ("starlette", "uvicorn")  # of the extra ``explore``


def _renamed(_: click.Context, option: click.Parameter, given: bool) -> None:
    if given:
        raise click.UsageError(f"{option.opts[0]} is called --cross-check now")


@command(
    "Design",
    "The best design for a mission.",
    "size:size",
    "solar-uav size atlantiksolar-design -m rafz-july --required-excess-time 2",
    "solar-uav size atlantiksolar-design -m mission.yaml --weather FILE --survive 0.9",
)
class Size(ModelOptions, LevelOptions, MassOptions, PlaceOptions, RequirementOptions, DrawnOptions):
    """Find the best design of AIRCRAFT (name, file or folder) for a mission."""

    mission: str | None = mission_option(None)
    objective: str = option(
        "--objective",
        type=click.Choice(OBJECTIVE_NAMES),
        default="min_mass",
        show_default=True,
        help="Masses and wingspan become as small as the mission's required excess "
        "time allows; max_excess_time ends at the bounds of the design space; the last two search "
        "for the most days, or degrees of latitude, in which one design flies perpetually.",
    )
    out_dir: str | None = out_option("figures")
    report_file: str | None = report_option()
    with_sensitivities: bool = option(
        "--sensitivities",
        is_flag=True,
        help="Tell how the optimum changes with each technology parameter.",
    )
    certify: None = option("--certify", is_flag=True, hidden=True, callback=_renamed)
    with_cross_check: bool = option(
        "--cross-check",
        is_flag=True,
        help="Try to beat the optimum with thousands of other designs in the simulator.",
    )
    whole_cells: bool = option(
        "--whole-cells",
        is_flag=True,
        help="Round the optimum to whole solar and battery cells, search the designs next to it "
        "and print the loss; for files with modules.layout and battery.pack.",
    )
    reliability: float | None = option(
        "--reliability",
        type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True, below=True),
        metavar="PROBABILITY",
        help="Least probability of the required excess time in every scenario when the uncertain "
        "inputs of aircraft and mission scatter, for instance 0.95.",
    )
    hold_station: float | None = option(
        "--hold-station",
        type=RealRange(0.0, 100.0, unit="the interval from 0 to 100", above=True, below=True),
        metavar="PERCENTILE",
        help="Fly as fast as this percentile of the wind of each latitude and month, for instance "
        "95: it holds its place for at least that share of the time. Short for the mission's "
        "wind: {percentile: 95, hold_station: true}. The shipped table of winds has the 95th "
        "alone; others come from a file of the mission's wind.",
    )
    weather_file: str | None = weather_option(
        "Size for the days of a weather record on the mission's dates, instead of clear ones; "
        "with --survive."
    )
    survive: float | None = option(
        "--survive",
        type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True),
        metavar="SHARE",
        help="Least share of the days of the weather record that close, for instance 0.9.",
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


def _refuse_given(options: Mapping[str, bool], why: str) -> None:
    """Refuse the first of some options that is given; its name stands for the braces."""
    for name, is_set in options.items():
        if is_set:
            raise click.UsageError(why.format(name))


@command(
    "Design",
    "Trade study: vary keys, judge or size.",
    "sweep:sweep",
    "solar-uav sweep atlantiksolar-design --vary battery_mass_kg=2:4:0.5",
)
class Sweep(ModelOptions, LevelOptions, MassOptions, WorkOptions, DrawnOptions):
    """Trade study: vary keys of AIRCRAFT (name, file or folder) and mission, each point judged.

    The exit code is 1 if any point could not be computed.
    """

    axes: tuple[Axis, ...] = option(
        "--vary",
        type=Parsed("key=values", "studies.sweeps.axes:parse_axis", stepped=True),
        multiple=True,
        required=True,
        help="KEY=first:last:step (last is met where the steps lead to it) or KEY=v1,v2,...; a key "
        "as of --set, or wingspan_m, aspect_ratio, battery_mass_kg, module_area_m2. May be "
        "repeated.",
    )
    objective: str | None = option(
        "--resize",
        type=click.Choice(RESIZE_NAMES),
        help="Size each point for it; varied design variables are held.",
    )
    cover: bool | None = option(
        "--cover/--no-cover",
        default=None,
        help="Fill the wing with modules, to maximum_module_coverage.  [default: where a "
        "parametric wing is varied and the module area is not]",
    )
    sample: SampleName = option(
        "--sample",
        type=click.Choice(_SAMPLES),
        default="grid",
        show_default=True,
        help="All combinations; points drawn between least and largest values; or one key at a "
        "time.",
    )
    samples: int = option(
        "--samples",
        type=click.IntRange(1, _MOST_SAMPLES),
        default=64,
        show_default=True,
        help="Number of points that lhs and sobol draw.",
    )
    seed: int = option(
        "--seed", type=click.IntRange(0), default=0, show_default=True, help="For drawing."
    )
    out_file: str | None = grid_option("all points")
    plot_file: str | None = plot_option("Draw the study")
    pareto: tuple[str, str] | None = option(
        "--pareto",
        nargs=2,
        metavar="X Y",
        help="Only the front of two results or varied keys, e.g. wingspan payload_mass: the points "
        "for which no other is better in both.",
    )
    sort: str | None = option(
        "--sort",
        metavar="KEY",
        help="Sort the table by a result or varied key, the least first; by -KEY the largest "
        "first.  [default: from best to worst]",
    )
    top: int | None = option(
        "--top",
        type=click.IntRange(1),
        metavar="N",
        help="Rows of the table.  [default: 15, with -v all]",
    )

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.pareto is not None and self.sort is not None:
            raise click.UsageError("a front has its own order: give --pareto or --sort")


@command(
    "Design",
    "Sliders for a design, on a local page.",
    "explore:explore",
    "solar-uav explore atlantiksolar-design -m central-europe-summer",
)
class Explore(ModelOptions):
    """Explore AIRCRAFT (name, file or folder) with sliders, on a page of this machine."""

    port: int = option(
        "--port",
        type=click.IntRange(0, 65535),
        default=0,
        show_default=True,
        help="Port on this machine; 0 for any that is free.",
    )
    no_browser: bool = option("--no-browser", is_flag=True, help="Only print the address.")

    def refuse(self) -> None:
        """Refuse to start without what the page is served by."""
        missing = next((name for name in _SERVER if find_spec(name) is None), None)
        if missing is not None:
            raise click.UsageError(
                f"explore needs {missing}: pip install 'solar-uav-sizing[explore]'"
            )


@command(
    "Design",
    "A design for other tools, papers and sheets.",
    "exchange:export",
    "solar-uav export atlantiksolar-design --out wing.avl",
    "solar-uav export sized -m rafz-july --out design.tex --out design.xlsx",
)
class Export(ModelOptions):
    """Write AIRCRAFT (name, file or folder) for other tools: its geometry, or its numbers."""

    out_files: tuple[str, ...] = option(
        "--out",
        type=click.Path(),
        multiple=True,
        required=True,
        metavar="FILE",
        help="Write geometry: .avl (AVL), .vspscript (OpenVSP), .py (AeroSandbox); or a table of "
        "the design on its mission: .tex, .xlsx, .csv, .parquet. May be given several times.",
    )
