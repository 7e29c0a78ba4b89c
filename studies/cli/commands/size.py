"""The command ``solar-uav size``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from solar.names import OBJECTIVE_NAMES
from studies.cli.checks import refuse_climb
from studies.cli.options import (
    EXIT_FAILED,
    console,
    load,
    mission_option,
    print_json,
    refuse_polar_night,
    require_path,
    required_time_option,
    solar_model,
    solar_options,
)


def _renamed(_: click.Context, option: click.Parameter, given: bool) -> None:
    if given:
        raise click.UsageError(f"{option.opts[0]} is called --cross-check now")


@click.command(short_help="The best design for a mission.")
@click.argument("aircraft")
@mission_option(None)
@click.option(
    "--objective",
    type=click.Choice(OBJECTIVE_NAMES),
    default=OBJECTIVE_NAMES[0],
    show_default=True,
    help="What to optimise; the last two search for the most days, or degrees of latitude, that "
    "one design keeps up.",
)
@required_time_option
@click.option("--out", "out_dir", type=click.Path(), help="Folder for the sized aircraft's files.")
@click.option(
    "--sensitivities",
    "with_sensitivities",
    is_flag=True,
    help="Tell how the optimum changes with each technology parameter.",
)
@click.option("--certify", is_flag=True, hidden=True, expose_value=False, callback=_renamed)
@click.option(
    "--cross-check",
    "with_cross_check",
    is_flag=True,
    help="Try to beat the optimum with thousands of other designs in the simulator.",
)
@solar_options
def size(
    aircraft: str,
    mission: str,
    objective: str,
    required_h: float | None,
    out_dir: str | None,
    with_sensitivities: bool,
    with_cross_check: bool,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Find the best design of AIRCRAFT (name or file) for a mission."""
    from sizing.aircraft import MeasuredAirframe
    from sizing.optimisation import study as sizing_study
    from sizing.optimisation.objectives import Objective

    asked = Objective(objective)
    if asked.of_range and (with_sensitivities or with_cross_check):
        raise click.UsageError(
            f"{objective} counts days or degrees: it has no sensitivities and no cross-check"
        )
    craft, where = load(aircraft, mission, overrides)
    if isinstance(craft.aircraft.airframe, MeasuredAirframe):
        from missions.files.validation import located_error

        raise located_error(
            craft.document,
            ("airframe", "kind"),
            "a measured aircraft cannot be sized; allowed: parametric",
        )
    refuse_climb(where, "size")
    if not asked.of_range:
        refuse_polar_night(where.mission, where, options=False)
    require_path(model, correction, craft, where)
    if out_dir is not None:
        from missions.files.writing import check_writable_folder

        check_writable_folder(Path(out_dir))
    study = sizing_study.size(
        craft.aircraft,
        where.mission,
        asked,
        solar_model(model, correction),
        required_excess_time_h=required_h,
        with_sensitivities=with_sensitivities,
        with_cross_check=with_cross_check,
    )
    record = study.record()
    if out_dir is not None and study.result.feasible:
        from studies.output.sizing_files import write_sizing

        write_sizing(Path(out_dir), study, record, craft)
    if as_json:
        print_json(record)
    else:
        from studies.output.tables import print_sizing_study

        print_sizing_study(console(), study, record)
        if out_dir is not None and study.result.feasible:
            click.echo(f"written to {out_dir}")
    if not study.result.feasible:
        sys.exit(EXIT_FAILED)
