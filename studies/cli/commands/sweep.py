"""The command ``solar-uav sweep``."""

from __future__ import annotations

import importlib.util
import math
import os
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from solar.names import RESIZE_NAMES
from studies.cli.checks import refuse_climb
from studies.cli.jobs import WorkOptions, completed, work_options
from studies.cli.options import (
    EXIT_FAILED,
    check_image,
    check_outputs,
    console,
    figure_bytes,
    load,
    mission_option,
    note_last,
    print_json,
    require_path,
    solar_model,
    solar_options,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from studies.sweeps.axes import Axis

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_ROWS = 40
# Results that are the same as a varied key.
_VARIED_AS = {"wingspan": "wingspan_m", "battery_mass": "battery_mass_kg"}


class Varied(click.ParamType["Axis"]):
    """A key and its values."""

    name = "key=values"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Axis:
        """Read key and values."""
        from studies.sweeps.axes import parse_axis

        try:
            axis = parse_axis(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if str(value).count(":") == 2:
            note_last(axis.values[-1], float(str(value).split(":")[1]), f"--vary {value}")
        return axis


@click.command(short_help="Trade study: vary keys, judge or size.")
@click.argument("aircraft")
@mission_option()
@click.option(
    "--vary",
    "axes",
    type=Varied(),
    multiple=True,
    required=True,
    help="KEY=first:last:step (last is met where the steps lead to it) or KEY=v1,v2,...; a key as "
    "of --set, or wingspan_m, aspect_ratio, battery_mass_kg, module_area_m2. May be repeated.",
)
@click.option(
    "--resize",
    "objective",
    type=click.Choice(RESIZE_NAMES),
    help="Size each point for this objective; varied design variables are held.",
)
@click.option(
    "--cover/--no-cover",
    default=None,
    help="Fill the wing with modules, to maximum_module_coverage.  [default: where a parametric "
    "wing is varied and the module area is not]",
)
@click.option(
    "--sample",
    type=click.Choice(_SAMPLES),
    default="grid",
    show_default=True,
    help="All combinations; points drawn between least and largest values; or one key at a time.",
)
@click.option(
    "--samples",
    type=click.IntRange(1, _MOST_SAMPLES),
    default=64,
    show_default=True,
    help="Number of points that lhs and sobol draw.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For drawing.")
@click.option("--out", "out_file", type=click.Path(), help="Write all points (nc, csv, parquet).")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the study (png, svg, pdf).")
@click.option(
    "--pareto",
    nargs=2,
    metavar="X Y",
    help="Draw the front of two results or varied keys instead, e.g. wingspan payload_mass.",
)
@work_options
@solar_options
def sweep(
    aircraft: str,
    mission: str,
    axes: tuple[Axis, ...],
    objective: str | None,
    cover: bool | None,
    sample: str,
    samples: int,
    seed: int,
    out_file: str | None,
    plot_file: str | None,
    pareto: tuple[str, str] | None,
    workers: int | None,
    scheduler: str | None,
    work_dir: str | None,
    keep_parts: bool,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Trade study: vary keys of AIRCRAFT (name or file) and mission, judge or size each point.

    The exit code is 1 if any point could not be computed.
    """
    options = WorkOptions(workers, scheduler, work_dir, keep_parts)
    if pareto is not None:
        if plot_file is None:
            raise click.UsageError("--pareto needs --plot")
        _check_pareto(pareto, axes, resized=objective is not None)
    check_image(plot_file)
    file_format = _file_format(out_file)
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "sweep")
    require_path(model, correction, craft, where)
    from missions.files.errors import InputError
    from missions.files.writing import write_files_atomically
    from studies.sweeps import study

    try:
        prepared = study.prepare(
            craft.aircraft,
            where.mission,
            axes,
            solar_model(model, correction),
            sample=sample,  # type: ignore[arg-type]  # click checked it
            samples=samples,
            seed=seed,
            resize=objective,
            cover=cover,
        )
    except InputError as error:
        raise InputError(
            [replace(p, source=f"--vary {p.source}") for p in error.problems]
        ) from None
    check_outputs(out=out_file, plot=plot_file)
    trouble = None
    with completed(prepared.job, options, out_file, "points") as outcome:
        data = study.dataset(prepared, outcome)
        contents: dict[str | os.PathLike[str], bytes] = {}
        if out_file is not None and file_format is not None:
            from studies.sweeps.files import to_bytes as to_file

            contents[out_file] = to_file(data, file_format)
        if plot_file is not None:
            try:
                contents[plot_file] = figure_bytes(_figure(data, pareto), plot_file)
            except ValueError as error:
                # The points are worth keeping even where there is nothing to draw.
                trouble = str(error)
        write_files_atomically(contents)
        if as_json:
            print_json(_record(data))
        else:
            _print(data)
        if trouble is not None:
            click.echo(f"solar-uav: no chart: {trouble}", err=True)
    if trouble is not None:
        sys.exit(EXIT_FAILED)


def _check_pareto(names: tuple[str, str], axes: tuple[Axis, ...], *, resized: bool) -> None:
    """Refuse names that no result will have before the work starts."""
    from studies.sweeps.axes import axis_names
    from studies.sweeps.points import BLANKS, SIZED_BLANKS

    blanks = SIZED_BLANKS if resized else BLANKS
    numbers = [name for name, blank in blanks.items() if isinstance(blank, float)]
    allowed = dict.fromkeys([*axis_names(axes), *numbers])
    for name in names:
        if name not in allowed:
            raise click.BadParameter(
                f"{name!r} is not one of {', '.join(allowed)}", param_hint="--pareto"
            )


def _file_format(path: str | None) -> str | None:
    if path is None:
        return None
    from studies.sweeps.files import FORMATS, table_format

    found = table_format(path)
    if found is None:
        allowed = ", ".join(f".{f}" for f in FORMATS)
        raise click.BadParameter(f"{path!r} must end in {allowed}", param_hint="--out")
    if found == "parquet" and importlib.util.find_spec("pyarrow") is None:
        raise click.BadParameter(
            "Parquet needs pyarrow: pip install pyarrow (the extra 'parquet')", param_hint="--out"
        )
    return found


def _figure(data: xr.Dataset, pareto: tuple[str, str] | None) -> Figure:
    from studies.sweeps.plots import figure_of, pareto_figure

    return figure_of(data) if pareto is None else pareto_figure(data, *pareto)


def _record(data: xr.Dataset) -> dict[str, Any]:
    """All points, JSON-ready; undefined and infinite numbers are null, the status says why."""
    from studies.sweeps.study import to_table

    table = to_table(data)
    rows = [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row.items()
        }
        for row in table.to_dict("records")
    ]
    return {
        "title": data.attrs["title"],
        "sample": data.attrs["sample"],
        "objective": data.attrs["objective"] or None,
        "status": _counts(data),
        "points": rows,
    }


def _counts(data: xr.Dataset) -> dict[str, int]:
    from studies.sweeps.study import to_table

    return {str(k): int(v) for k, v in to_table(data)["status"].value_counts().items()}


def _print(data: xr.Dataset) -> None:
    """How many points end in which way, and the points where they fit on a screen."""
    from rich.table import Table

    from studies.sweeps.axes import unit_label
    from studies.sweeps.study import to_table

    counts = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in _counts(data).items())
    count = data["status"].size
    noun = "point" if count == 1 else "points"
    console().print(f"{data.attrs['title']}: {count} {noun}: {counts}")
    rows = to_table(data)
    varied = [str(name) for name in data.coords if name != "sample"]
    if "varied" in varied:
        # Of each point only one key differs from the file.
        rows["value"] = [row[row["varied"]] if row["varied"] else "" for _, row in rows.iterrows()]
        varied = ["varied", "value"]
    sized = ("wingspan", "battery_mass") if data.attrs["objective"] else ()
    results = [name for name in sized if _VARIED_AS[name] not in varied]
    names = [*varied, "status", *results, "total_mass", "excess_time", "charge_margin"]
    table = Table()
    for name in names:
        unit = data[name].attrs.get("units", "1") if name in data else "1"
        head = _head(name) if unit == "1" else f"{_head(name)} [{unit_label(unit)}]"
        table.add_column(head, justify="left" if name in ("status", "varied") else "right")
    for _, row in rows.head(_ROWS).iterrows():
        table.add_row(*(_cell(row[name], ".6g" if name in varied else ".2f") for name in names))
    console().print(table)
    if len(rows) > _ROWS:
        console().print(f"... {len(rows) - _ROWS} more points: --out FILE or --json has them all")


def _head(name: str) -> str:
    """Name without the unit that it ends in."""
    from studies.sweeps.axes import without_unit

    return without_unit(name).replace("_", " ")


def _cell(value: Any, form: str) -> str:
    if isinstance(value, str):
        return value.replace("_", " ")
    if math.isnan(value):
        return "-"
    return "unlimited" if math.isinf(value) else f"{value:{form}}"
