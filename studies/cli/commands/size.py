"""The command ``solar-uav size``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import click

from sizing.program.objectives import OBJECTIVE_NAMES, Objective
from studies.cli.command import Command, RealRange, option
from studies.cli.options import (
    CaseOptions,
    PlaceOptions,
    case_options,
    figure_options,
    mass_option,
    out_option,
    place_options,
    report_option,
    required_time_option,
    weather_option,
)
from studies.output.figures.options import FigureOptions


def _renamed(_: click.Context, option: click.Parameter, given: bool) -> None:
    if given:
        raise click.UsageError(f"{option.opts[0]} is called --cross-check now")


@dataclass(frozen=True)
class Size:
    """Find the best design of AIRCRAFT (name, file or folder) for a mission."""

    case: CaseOptions = case_options(mission=None, with_levels=True)
    mass_kg: float | None = mass_option()
    objective: str = option(
        "--objective",
        type=click.Choice(OBJECTIVE_NAMES),
        default="min_mass",
        show_default=True,
        help="Masses and wingspan become as small as the mission's required excess "
        "time allows; max_excess_time ends at the bounds of the design space; the last two search "
        "for the most days, or degrees of latitude, in which one design flies perpetually.",
    )
    required_h: float | None = required_time_option()
    place: PlaceOptions = place_options()
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
    figure: FigureOptions = figure_options()

    def __post_init__(self) -> None:
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
            given, other = names if self.survive is None else names[::-1]
            raise click.UsageError(f"{given} needs {other} as well")
        if self.survive is not None:
            self.place.refuse_with_weather()
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
    for name, given in options.items():
        if given:
            raise click.UsageError(why.format(name))


size = Command(
    "size",
    Size,
    "size:size",
    "solar-uav size atlantiksolar-design -m rafz-july --required-excess-time 2",
    "solar-uav size atlantiksolar-design -m mission.yaml --weather FILE --survive 0.9",
)
