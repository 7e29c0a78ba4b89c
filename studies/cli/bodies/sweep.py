"""What ``solar-uav sweep`` does."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from missions.files.errors import InputError
from studies.cli.commands.design import Sweep
from studies.cli.files import (
    Case,
    load,
    require_climb_power,
    require_climber,
    require_path,
)
from studies.cli.jobs import completed
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import call, deliver, figure_of
from studies.cli.telling import tell_error
from studies.output.formats import grid_format
from studies.output.gridded import DESCRIBED, to_bytes
from studies.study import blanks_of
from studies.sweeps.axes import axis_names
from studies.sweeps.points import described_flights, varies_climb
from studies.sweeps.study import prepare

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import Dataset

    from studies.study import Study


def sweep(options: Sweep) -> None:
    """Compute the points of a trade study, write them, and tell them."""
    out_file, plot_file = options.out_file, options.plot_file
    case = load(options)
    climbs = case.mission.climb is not None or varies_climb(axis.key for axis in options.axes)
    _check_shown(options, climbs=climbs)
    require_path(case)
    if options.objective is None:
        require_climber(case)
    else:
        require_climb_power(case)
    with completed(_prepared(case, options), options, out_file) as points:
        from studies.sweeps.results import SweepResult  # pandas and xarray

        data = points.to_xarray()
        result = SweepResult(data, options.sort, options.top, options.pareto)
        files = {
            out_file: lambda path: to_bytes(data, grid_format(path), "points"),
            plot_file: figure_of(lambda: _chart(data, options)),
        }
        try:
            step = f"{call('explore')} (the same with sliders)"
            deliver(case, result, files, next_step=step)
        except ValueError as error:
            # The points are worth keeping even where there is nothing to draw.
            tell_error(f"solar-uav: no chart: {error}")
            sys.exit(EXIT_FAILED)


def _prepared(case: Case, options: Sweep) -> Study:
    """Return points ready to be computed; refuse wrong ones by the option."""
    try:
        return prepare(
            case.aircraft,
            case.mission,
            options.axes,
            case.solar,
            sample=options.sample,
            samples=options.samples,
            seed=options.seed,
            resize=options.objective,
            cover=options.cover,
            total_mass_kg=case.total_mass_kg,
        )
    except InputError as error:
        named = [replace(p, source=f"--vary {p.source}") for p in error.problems]
        raise InputError(named) from None


def _check_shown(options: Sweep, *, climbs: bool) -> None:
    """Refuse names that no result will have, before the work starts."""
    described = DESCRIBED if options.objective else described_flights(climbs=climbs)
    varied = axis_names(options.axes)
    numbers = [n for n, axis in zip(varied, options.axes, strict=True) if not axis.names]
    numbers += [*(n for n, blank in blanks_of(described).items() if isinstance(blank, float))]
    texts = [n for n in varied if n not in numbers]
    _check_names("--pareto", options.pareto or (), numbers)
    sorted_by = () if options.sort is None else (options.sort.removeprefix("-"),)
    _check_names("--sort", sorted_by, ["status", *texts, *numbers])


def _check_names(option: str, names: Sequence[str], allowed: list[str]) -> None:
    for name in names:
        if name not in allowed:
            known = ", ".join(dict.fromkeys(allowed))
            raise click.BadParameter(f"{name!r} is not one of {known}", param_hint=option)


def _chart(data: Dataset, options: Sweep) -> Figure:
    """Return the chart of the points, or of their front."""
    from studies.sweeps.plots import plot_pareto, plot_sweep  # matplotlib

    if options.pareto is None:
        return plot_sweep(data, figure=options.figure)
    return plot_pareto(data, *options.pareto, figure=options.figure)
