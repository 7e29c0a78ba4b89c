"""Tables on altitude for the documentation: ceilings of the shipped aircraft, gains by climbing."""

from __future__ import annotations

import numpy as np

from missions.dates import day_of_year
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.mission import Scenarios
from sizing.ceiling import highest_perpetual_altitude
from sizing.climb import climb_performance
from sizing.day.light import SolarModel
from sizing.day.module_power import convection_in_flight
from sizing.library import load_aircraft
from sizing.performance import performance
from sizing.program.cells import size_cells
from sizing.program.objectives import Objective
from solar.modules import STC_TEMPERATURE_C
from studies.render.tables import Column, Table

AIRCRAFT = ("atlantiksolar-as2", "atlantiksolar-design", "sky-sailor")
MODELS = (SolarModel("CAM"), SolarModel("CAM", "report"), SolarModel("CDM"))
SIZED_LATITUDES = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)
SIZED_DATES = ("03-21", "06-21", "09-21", "12-21")
# (date, ceiling [m]) of AtlantikSolar AS-2 at 47.6 N.
CLIMBS = (("06-21", 1536), ("06-21", 3536), ("06-21", 6536), ("10-10", 3536))


def ceilings() -> Table:
    """Highest altitude of perpetual flight at 47.6 N on 21 June in standard air."""
    mission = load_mission("rafz-july", ["dates={on: 06-21}", "air={}"])
    rows = []
    for name in AIRCRAFT:
        aircraft = load_aircraft(name)
        found = [highest_perpetual_altitude(aircraft, mission, m, step_m=1000.0) for m in MODELS]
        rows.append((f"`{name}`", *(f.highest and f.highest.altitude_m for f in found)))
    models = [Column(m.label, form="{:.0f} m", missing="none") for m in MODELS]
    return Table("ceilings of perpetual flight", (Column("aircraft"), *models), tuple(rows))


def climb_sizes() -> Table:
    """Lightest design of AtlantikSolar over latitude and season, without climbs and with 3000 m."""
    aircraft = load_aircraft("atlantiksolar-design")
    places = [(latitude, date) for latitude in SIZED_LATITUDES for date in SIZED_DATES]
    scenarios = Scenarios(
        np.array([place[0] for place in places]),
        np.array([day_of_year(place[1]) for place in places]),
    )
    level = load_mission("rafz-july")
    missions = [level, with_values(level, {"climb": {"ceiling_m": 3536.0}})]
    found = [size_cells(aircraft, one, scenarios, Objective.min_mass) for one in missions]
    rows = []
    for i, (latitude, date) in enumerate(places):
        masses = [float(one.total_mass_kg[i]) for one in found]
        rows.append(
            (
                *(latitude, date),
                *(float(one.variables.wingspan_m[i]) for one in found),
                *masses,
                *(100.0 * (mass / masses[0] - 1.0) for mass in masses[1:]),
            )
        )
    names = ("level", "climbs")
    columns = (
        Column("latitude", "latitude", "°", ".0f"),
        Column("date"),
        *(Column(f"span {name}", f"span, {name}", "m", ".2f") for name in names),
        *(Column(f"mass {name}", f"mass, {name}", "kg", ".2f") for name in names),
        *(Column(f"less {name}", f"mass saved, {name}", "%", "+.1f") for name in names[1:]),
    )
    return Table("lightest designs with and without climbs", columns, tuple(rows))


def climbs() -> Table:
    """What climbing gains AtlantikSolar AS-2 at 47.6 N, 536 m, in standard air."""
    aircraft = load_aircraft("atlantiksolar-as2")
    rows = []
    for date, ceiling_m in CLIMBS:
        climb = f"climb={{ceiling_m: {ceiling_m}}}"
        mission = load_mission("rafz-july", [f"dates={{on: {date}}}", "air={}", climb])
        result = climb_performance(aircraft, mission)
        values = (
            result.altitude_m.max(axis=-1),
            result.stored_height_wh,
            result.gliding_h,
            result.constant.cycle.excess_time_h,
            result.performance.cycle.excess_time_h,
            result.gain_h,
        )
        rows.append((date, ceiling_m, *(float(value[0]) for value in values)))
    columns = (
        Column("date"),
        Column("ceiling_m", "ceiling", "m"),
        Column("reached_m", "reached", "m", ".0f"),
        Column("potential_energy_wh", "potential energy", "Wh", ".1f"),
        Column("gliding_h", "gliding", "h", ".1f"),
        Column("level_excess_time_h", "excess time at 536 m", "h", ".2f"),
        Column("climb_excess_time_h", "with climb", "h", ".2f"),
        Column("gain_h", "gain", "h", "z.2f"),
    )
    return Table("gains by climbing", columns, tuple(rows))


def module_heat() -> Table:
    """Modules of the stratospheric aircraft at noon of 21 June at 30 N, by altitude."""
    aircraft = load_aircraft("stratosphere-design")
    columns = (
        Column("altitude", "altitude", "km"),
        Column("air", "air", "°C", ".0f"),
        Column("speed", "airspeed", "m/s", ".1f"),
        Column("flow", "convection of a face", "W/(m² K)", ".1f"),
        Column("modules", "modules at noon", "°C", ".0f"),
        Column("less", "power beside modules as cold as the air", "%", "+.1f"),
    )
    rows = []
    for altitude_km in (4, 8, 12, 16, 20, 24):
        given = {"altitude_m": 1000.0 * altitude_km, "dates": {"on": "06-21"}, "latitude_deg": 30.0}
        mission = load_mission("stratosphere-mission", given | {"wind": None})
        air_c = float(mission.air_state().temperature_c)
        cold = load_mission(
            "stratosphere-mission", given | {"wind": None, "air": {"module_temperature_c": air_c}}
        )
        flown, without = (performance(aircraft, one) for one in (mission, cold))
        noon = len(flown.day.time_h) // 2
        ratio = float(flown.solar_power_w[0, noon] / without.solar_power_w[0, noon])
        modules = aircraft.modules
        at_air = float(modules.temperature_efficiency(air_c))
        celsius = STC_TEMPERATURE_C + (1.0 - ratio * at_air) / modules.temperature_coefficient_per_k
        convection = convection_in_flight(aircraft, mission)
        speed = float(flown.design.airspeed_m_per_s)
        rows.append((altitude_km, air_c, speed, convection, celsius, 100.0 * (ratio - 1.0)))
    return Table("", columns, tuple(rows))
