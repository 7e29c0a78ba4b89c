"""The command ``solar-uav ceiling``."""

from __future__ import annotations

import click

from studies.cli.checks import refuse_climb
from studies.cli.options import (
    EXIT_FAILED,
    RealRange,
    check_image,
    check_outputs,
    console,
    csv_bytes,
    load,
    mission_option,
    print_json,
    progress_bar,
    refuse_polar_night,
    require_path,
    solar_model,
    solar_options,
    write_results,
)

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0


@click.command(short_help="How high it flies for ever.")
@click.argument("aircraft")
@mission_option()
@click.option(
    "--highest",
    "highest_m",
    type=RealRange(-500.0, _HIGHEST_M, unit="metres"),
    default=20000.0,
    show_default=True,
    metavar="METRES",
    help="End of the search, which starts at the mission's altitude.",
)
@click.option(
    "--step",
    "step_m",
    type=RealRange(_LEAST_STEP_M, 10000.0, unit="metres"),
    default=250.0,
    show_default=True,
    metavar="METRES",
    help="Spacing of the altitudes that are tried.",
)
@click.option("--csv", "csv_file", type=click.Path(), help="Write the altitudes as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw them (png, svg, pdf).")
@solar_options
def ceiling(
    aircraft: str,
    mission: str,
    highest_m: float,
    step_m: float,
    csv_file: str | None,
    plot_file: str | None,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Find how high AIRCRAFT (name or file) flies for ever; exit code 1 if nowhere."""
    from sizing.altitude.ceiling import highest_perpetual_altitude
    from studies import ceiling as results

    check_image(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "ceiling")
    refuse_polar_night(where.mission, where, options=False)
    require_path(model, correction, craft, where)
    if highest_m <= where.mission.altitude_m:
        message = f"must be above the mission's altitude_m of {where.mission.altitude_m:g}"
        raise click.BadParameter(f"{message} (got {highest_m:g})", param_hint="--highest")
    solar = solar_model(model, correction)
    with progress_bar("altitudes") as progress:
        found = highest_perpetual_altitude(
            craft.aircraft,
            where.mission,
            solar,
            highest_m=highest_m,
            step_m=step_m,
            progress=progress,
        )
    record = results.to_json(found, craft.aircraft.name, where.mission.name, solar)
    title = f"{craft.aircraft.name}, {where.mission.name}"
    write_results(
        csv_file,
        lambda: csv_bytes(results.altitude_table(found)),
        plot_file,
        lambda: results.ceiling_figure(found, title, solar),
    )
    if as_json:
        print_json(record)
    else:
        results.print_ceiling(console(), found, record, where.mission.scenarios())
    if found.highest is None:
        raise SystemExit(EXIT_FAILED)
