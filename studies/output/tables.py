"""Tables for the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from missions.dates import date_label, day_of_year
from missions.mission import latitude_label
from sizing.analysis import Analysis, clock_label
from sizing.optimisation.objectives import Objective
from solar.names import ATTITUDE_MODELS

if TYPE_CHECKING:  # each command prints its own results alone
    from sizing.optimisation.cross_check import CrossCheck
    from sizing.optimisation.relaxations import Relaxation
    from sizing.optimisation.result import SizingResult
    from sizing.optimisation.sensitivity import ConstraintMultiplier, Sensitivity
    from sizing.optimisation.study import SizingStudy
    from studies.models.transfer import TransferredError
    from studies.validation.published import Comparison

_WIDE = 105


def hours(value: float | None, missing: str = "-") -> str:
    """Hours with two decimals."""
    return missing if value is None else f"{value:.2f} h"


def print_analysis(console: Console, analysis: Analysis, record: dict[str, Any]) -> None:
    """One analysis: the worst scenario in full, the others as rows, the flight if there is one."""
    solar = analysis.performance.solar
    where = analysis.performance.day.scenarios.label(analysis.worst)
    several = len(record["scenarios"]) > 1
    worst = " (worst scenario)" if several else ""
    title = f"{record['aircraft']} at {where}{worst}: {record['status'].replace('_', ' ')}"
    console.print(title, style="bold")
    table = Table(show_header=False)
    table.add_column()
    table.add_column(justify="right")
    rows = _analysis_rows(record)
    if "climb" in record:
        rows += _climb_rows(record["climb"])
    for label, text in rows:
        table.add_row(label, text)
    console.print(table)
    if several:
        console.print(_scenario_table(record["scenarios"]))
    if "flight" in record:
        console.print(_flight_table(record["flight"]))
    if record["airspeed_above_wind"] is False:
        console.print(
            f"Warning: the airspeed of {record['airspeed_m_per_s']:.1f} m/s does not exceed the "
            f"mission's wind of {analysis.mission.wind_m_per_s:g} m/s.",
            style="bold red",
        )
    band = record["uncertainty"]
    low, high = band["excess_time_low_h"], band["excess_time_high_h"]
    spread = (
        "leaves the excess time without end"
        if low is None and high is None
        else f"puts the excess time between {hours(low, 'no end')} and {hours(high, 'no end')}"
    )
    error = "the model's RMS error" if solar.correction == "none" else "the RMS error left after it"
    console.print(
        f"{solar.model}, correction: {solar.correction}; {error} of "
        f"{100 * band['solar_power_rms_relative']:.0f} % of the mean power {spread}.",
        style="dim",
    )


def _analysis_rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    lit = record["status"] == "always_lit"
    endless = record["status"] in ("perpetual", "always_lit")
    endurance = hours(record["endurance_h"], "no end" if endless else "over a year")
    if record["best_launch_h"] is not None:
        endurance += f", launched {clock_label(record['best_launch_h'])}"
    airspeed = record["airspeed_m_per_s"]
    return [
        ("excess time", hours(record["excess_time_h"], "no end" if lit else "-")),
        ("charge margin", hours(record["charge_margin_h"])),
        ("endurance", endurance),
        ("minimum state of charge", f"{100 * record['minimum_state_of_charge']:.1f} %"),
        ("total mass", f"{record['total_mass_kg']:.2f} kg"),
        ("battery", f"{record['battery_energy_wh']:.0f} Wh"),
        ("airspeed", "-" if airspeed is None else f"{airspeed:.1f} m/s"),
        ("load", f"{record['power_out_w']:.1f} W"),
        ("solar energy of the day", f"{record['solar_energy_wh']:.0f} Wh"),
        (
            "sunrise, sunset (solar time)",
            f"{clock_label(record['sunrise_h'])}, {clock_label(record['sunset_h'])}",
        ),
        (
            "equal power, morning and evening",
            f"{clock_label(record['equal_power_morning_h'])}, "
            f"{clock_label(record['equal_power_evening_h'])}",
        ),
        ("full charge", clock_label(record["full_charge_h"])),
    ]


def _climb_rows(climb: dict[str, Any]) -> list[tuple[str, str]]:
    gain = climb["gain_in_excess_time_h"]
    return [
        ("highest altitude", f"{climb['maximum_altitude_m']:.0f} m"),
        ("gliding in the evening", hours(climb["gliding_h"])),
        ("stored height", f"{climb['stored_height_wh']:.1f} Wh"),
        (
            "excess time at constant altitude",
            hours(climb["constant_altitude_excess_time_h"], "no end"),
        ),
        ("gained by climbing", "-" if gain is None else f"{gain:+.2f} h"),
    ]


def _scenario_table(records: list[dict[str, Any]]) -> Table:
    table = Table(title="all scenarios", title_justify="left")
    table.add_column("latitude")
    table.add_column("date")
    for name in ("excess time", "charge margin", "min. charge", "endurance"):
        table.add_column(name, justify="right")
    for r in records:
        endless = r["status"] in ("perpetual", "always_lit")
        table.add_row(
            latitude_label(r["latitude_deg"]),
            date_label(r["day_of_year"]),
            hours(r["excess_time_h"], "no end"),
            hours(r["charge_margin_h"]),
            f"{100 * r['minimum_state_of_charge']:.1f} %",
            hours(r["endurance_h"], "no end" if endless else "over a year"),
        )
    return table


def _flight_table(flight: dict[str, Any]) -> Table:
    first_day = day_of_year(flight["launch"].split()[0])
    table = Table(title="flight on the calendar", show_header=False, title_justify="left")
    table.add_column()
    table.add_column(justify="right")
    table.add_row("launch (local time)", flight["launch"])
    for hour in flight["full_charge_clock_h"]:
        table.add_row("full charge", clock_label(hour, first_day=first_day))
    table.add_row("minimum state of charge", f"{100 * flight['minimum_state_of_charge']:.1f} %")
    table.add_row("flown", hours(flight["duration_h"]))
    table.add_row("state of charge at the end", f"{100 * flight['final_state_of_charge']:.1f} %")
    if flight["empty_clock_h"] is not None:
        table.add_row("battery empty", clock_label(flight["empty_clock_h"], first_day=first_day))
    return table


def print_sizing_study(console: Console, study: SizingStudy, record: dict[str, Any]) -> None:
    """A sizing, and what was asked about it."""
    print_sizing(console, study.result, record)
    _print_path_airspeed(console, study, record)
    if study.band is not None and study.band.first is not None:
        console.print(_range_text(record["range"]))
    if study.as_assumed is not None:
        reached = record["as_assumed"]["excess_time_h"]
        console.print(
            "without the mission's bands the excess time would be " + hours(reached, "without end")
        )
    if study.result.status.name == "infeasible" and study.band is None:
        _print_relaxations(console, study.relaxations)
    if study.worth is not None:
        print_sensitivities(console, study.worth, study.result.objective)
    if study.multipliers:
        _print_multipliers(console, study.multipliers, study.result.objective)
    if study.cross_check is not None:
        print_cross_check(console, study.cross_check, study.result.objective)


def _print_path_airspeed(console: Console, study: SizingStudy, record: dict[str, Any]) -> None:
    """Say so where solar power was computed on a path flown at another airspeed than the design's.

    On the report's morning 7 % less airspeed changes the power of FM by 0.4 %; below 5 % there is
    nothing to say.
    """
    if study.result.simulated is None:
        return
    solar = study.result.simulated.solar
    flown = getattr(study.mission.flight_path, "airspeed_m_per_s", None)
    if flown is None or (solar.model not in ATTITUDE_MODELS and solar.correction != "loiter"):
        return
    if abs(record["airspeed_m_per_s"] / flown - 1.0) > 0.05:
        console.print(
            f"solar power is that of the mission's flight path at {flown:g} m/s, not at the "
            f"design's {record['airspeed_m_per_s']:.1f} m/s: set flight_path.airspeed_m_per_s"
        )


def _range_text(band: dict[str, Any]) -> str:
    if "days" in band:
        ends = " to ".join(date_label(day_of_year(band[end])) for end in ("from", "to"))
        return f"season: {ends}, {band['days']} days"
    ends = " to ".join(latitude_label(band[end]) for end in ("from_deg", "to_deg"))
    return f"latitudes: {ends}, {band['width_deg']:g} degrees"


def _print_multipliers(
    console: Console, multipliers: list[ConstraintMultiplier], objective: Objective
) -> None:
    table = Table(title="what easing a constraint gains", title_justify="left")
    table.add_column("constraint", overflow="fold")
    table.add_column(f"{objective.unit}", justify="right")
    table.add_column("for easing by")
    for one in multipliers:
        table.add_row(one.constraint, f"{one.gain:.3g}", one.step)
    console.print(table)


def _print_relaxations(console: Console, relaxations: tuple[Relaxation, ...]) -> None:
    if not relaxations:
        console.print("no single parameter that was tried would make it feasible")
        return
    console.print("feasible with one of these, all else unchanged:")
    for one in relaxations:
        console.print(f"  {one.text}")


def print_sizing(console: Console, result: SizingResult, record: dict[str, Any]) -> None:
    """One sizing: the design, its masses, what limits it; or why there is none."""
    title = f"{record['aircraft']} sized for {record['mission']}: {result.status.name}"
    console.print(title.replace("_", " "), style="bold")
    if result.design is None:
        for violation in result.violations:
            console.print(f"  {violation.requirement}: {violation.text}")
        if result.active_constraints:
            console.print("  held back by: " + "; ".join(result.active_constraints))
        return
    table = Table(show_header=False)
    table.add_column()
    table.add_column(justify="right")
    simulated = record["simulated"]
    worst = record["worst_scenario"]["label"]
    quantities = record["quantities"]
    for label, text in (
        ("wingspan", f"{record['wingspan_m']:.3f} m"),
        ("aspect ratio", f"{record['aspect_ratio']:.2f}"),
        ("battery mass", f"{record['battery_mass_kg']:.3f} kg"),
        ("module area", f"{record['module_area_m2']:.3f} m2"),
        ("total mass", f"{record['total_mass_kg']:.3f} kg"),
        ("airspeed", f"{record['airspeed_m_per_s']:.2f} m/s"),
        ("stall speed", f"{quantities['stall_speed_m_per_s']:.2f} m/s"),
        ("wing loading", f"{quantities['wing_loading_kg_per_m2']:.2f} kg/m2"),
        ("climb rate at rated power", f"{quantities['climb_rate_m_per_s']:.2f} m/s"),
        ("load", f"{record['power_out_w']:.1f} W"),
        (
            f"objective {result.objective.value}",
            _with_unit(result.objective_value, ".4g", result.objective),
        ),
        (f"excess time simulated, {worst}", hours(simulated["excess_time_h"], "no end")),
        ("minimum state of charge", f"{100 * simulated['minimum_state_of_charge']:.1f} %"),
    ):
        table.add_row(label, text)
    console.print(table)
    masses = Table(title="mass budget", title_justify="left")
    masses.add_column("item")
    masses.add_column("kg", justify="right")
    for item, mass in record["masses_kg"].items():
        masses.add_row(item, f"{mass:.3f}")
    console.print(masses)
    console.print("limited by: " + "; ".join(result.active_constraints))
    solver = result.solver
    console.print(
        f"{solver.iterations} iterations, {solver.solves} solve{'s' if solver.solves > 1 else ''}, "
        f"{1000 * solver.time_s:.0f} ms (built in {1000 * solver.build_time_s:.0f} ms)",
        style="dim",
    )


def _with_unit(value: float | None, digits: str, objective: Objective) -> str:
    """Value of an objective with its unit; an excess time may have no end."""
    if value is None or math.isnan(value):
        return "-"
    return "no end" if math.isinf(value) else f"{value:{digits}} {objective.unit}"


def print_published(console: Console, rows: list[Comparison]) -> None:
    """Published beside computed numbers."""
    table = Table(title="published and computed", title_justify="left")
    table.add_column("quantity", overflow="fold")
    for name in ("published", "computed", "difference", "allowed"):
        table.add_column(name, justify="right")
    table.add_column("met")
    source = None
    for r in rows:
        if r.source != source:
            source = r.source
            table.add_section()
            table.add_row(source, style="bold")
        table.add_row(
            f"  {r.quantity}",
            f"{r.published:.4g} {r.unit}",
            f"{r.computed:.4g}",
            f"{r.difference:+.2g}",
            f"{r.allowed:.2g}",
            "yes" if r.met else "no",
        )
    console.print(table)


def print_reproduction(console: Console, record: dict[str, Any]) -> None:
    """Report's table and windows, published beside computed, and what the assumptions are worth."""
    table = Table(title="mean solar power, published and computed", title_justify="left")
    table.add_column("mean")
    for name in ("published", "computed", "difference", "flight"):
        table.add_column(name, justify="right")
    for model, row in record["models"].items():
        _add_power_row(table, f"{model}, whole period", row, record["measured_w"])
    for row in record["windows"]:
        name = f"FM, {row['from_h']:g} to {row['to_h']:g} h"
        _add_power_row(table, name, row, row["measured_w"])
    console.print(table)
    spread = Table(title="one assumption changed at a time [W]", title_justify="left")
    spread.add_column("assumption")
    models = list(record["models"])
    for name in (*models, *(f"FM {w['from_h']:g} h" for w in record["windows"])):
        spread.add_column(name, justify="right")
    for case in record["sensitivities"]:
        values = [case["models_w"][m] for m in models] + case["windows_w"]
        spread.add_row(f"{case['assumption']} {case['value']}", *(f"{v:.1f}" for v in values))
    console.print(spread)
    path = record["assumptions"]["flight_path"]
    console.print(
        f"Assumed: {path['kind']} of {path['radius_m']:g} m at {path['airspeed_m_per_s']:g} m/s, "
        f"pitch {path['pitch_deg']:g} deg, wind {record['assumptions']['wind_m_per_s']:g} m/s from "
        f"{record['assumptions']['wind_from_deg']:g} deg, air "
        f"{record['assumptions']['ambient_temperature_c']:g} C.",
        style="dim",
    )


def _add_power_row(table: Table, name: str, row: dict[str, Any], measured_w: float) -> None:
    published, computed = row["published_w"], row["computed_w"]
    table.add_row(
        name,
        f"{published:.2f} W",
        f"{computed:.2f} W",
        f"{100 * (computed / published - 1):+.1f} %",
        f"{measured_w:.1f} W",
    )


def print_transfer(console: Console, errors: list[TransferredError]) -> None:
    """Errors of the simple models against the Full Model on the path, by place, season and wind."""
    winds = sorted({e.wind_m_per_s for e in errors})
    table = Table(title="error of daily solar energy [%]", title_justify="left")
    for name in ("model", "latitude", "date"):
        table.add_column(name)
    for wind in winds:
        table.add_column(f"{wind:g} m/s", justify="right")
    rows: dict[tuple[str, float, int], list[str]] = {}
    for e in errors:
        spread = f" ± {100 * e.half_range:.1f}" if e.wind_m_per_s > 0 else ""
        key = (e.model, e.latitude_deg, e.day_of_year)
        rows.setdefault(key, []).append(f"{100 * e.error:+.1f}{spread}")
    for (model, latitude, day), cells in rows.items():
        table.add_row(model, latitude_label(latitude), date_label(day), *cells)
    console.print(table)
    console.print("±: half the range over eight wind directions", style="dim")


def print_efficiencies(console: Console, data: Any) -> None:
    """Component efficiencies of the Full Model at every full hour of the lit day."""
    table = Table(
        title=f"{data.attrs['aircraft']}, {data.attrs['scenario']} (FM)", title_justify="left"
    )
    names = {
        "time": "solar time",
        "specific_power": "W/m2",
        "module_efficiency": "module",
        "incidence_efficiency": "incidence",
        "low_light_efficiency": "low light",
        "temperature_efficiency": "temperature",
        "mppt_efficiency": "tracker",
    }
    for label in names.values():
        table.add_column(label, justify="right")
    means = data.mean("surface")
    for index, hour in enumerate(means["time"].to_numpy()):
        if abs(hour - round(hour)) > 1e-6:
            continue
        values = [float(means[name][index]) for name in names if name != "time"]
        table.add_row(clock_label(hour), f"{values[0]:.1f}", *(f"{v:.3f}" for v in values[1:]))
    console.print(table)


def print_sensitivities(
    console: Console, worth: list[Sensitivity], objective: Objective, *, rows: int = 15
) -> None:
    """What each technology parameter is worth, most important first."""
    if not worth:
        console.print(f"no sensitivities: {objective.value} has no end")
        return
    unit = objective.unit
    table = Table(title=f"sensitivities of {objective.value}", title_justify="left")
    table.add_column("parameter", overflow="fold")
    # A narrow terminal shows the names whole and leaves out what JSON and CSV tell as well.
    wide = console.width >= _WIDE
    for name in (
        "value",
        *([f"{unit} per unit"] if wide else []),
        f"{unit} per +1 %",
        "elasticity",
    ):
        table.add_column(name, justify="right")
    for s in worth[:rows]:
        elasticity = "-" if s.elasticity is None else f"{s.elasticity:+.3f}"
        per_unit = [f"{s.derivative:+.4g}"] if wide else []
        table.add_row(
            s.parameter.removeprefix("airframe."),
            f"{s.value:.4g}",
            *per_unit,
            f"{s.per_percent:+.4f}",
            elasticity,
        )
    console.print(table)


def print_cross_check(console: Console, check: CrossCheck, objective: Objective) -> None:
    """Whether a search by simulation found a better design than the optimum."""
    from sizing.optimisation.result import RELATIVE_TOLERANCE

    verdict = "cross-check passed" if check.cross_checked else "cross-check FAILED"
    found = (
        f"the best of them has {_with_unit(check.best_found, '.5g', objective)} "
        f"({check.found_by}), better by {_with_unit(check.advantage, '.2g', objective)}"
        if check.advantage > RELATIVE_TOLERANCE * abs(check.objective_value)
        else "none is better by more than the tolerance"
    )
    fine = (
        "misses its requirement"
        if math.isnan(check.fine_step_value)
        else f"has {_with_unit(check.fine_step_value, '.5g', objective)}"
    )
    console.print(
        f"{verdict}: {check.designs_tried} designs tried, {found}; with a time step of one "
        f"minute the optimum {fine}"
    )


def print_seasons(console: Console, data: Any, season: Any) -> None:
    """Days of perpetual flight at each latitude, with the first and the last of them."""
    table = Table(title=f"{data.attrs['title']}: perpetual flight", title_justify="left")
    table.add_column("latitude", justify="right")
    table.add_column(f"days of {data.sizes['day']} mapped", justify="right")
    table.add_column("largest excess time", justify="right")
    best = data["excess_time"].max("day")
    for index, latitude in enumerate(data["latitude"].to_numpy()):
        most = float(best[index])
        table.add_row(
            latitude_label(float(latitude)),
            f"{int(season[index])}",
            hours(most if math.isfinite(most) else None, "no end"),
        )
    console.print(table)
