"""Tables on altitude for the documentation: ceilings of the shipped aircraft, gains by climbing."""

from __future__ import annotations

from missions.library import load_mission
from sizing.ceiling import highest_perpetual_altitude
from sizing.climb import compare_with_constant
from sizing.day.light import SolarModel
from sizing.day.module_power import convection_in_flight
from sizing.library import load_aircraft
from sizing.performance import performance
from solar.modules import STC_TEMPERATURE_C
from studies.render.tables import Column, Table

AIRCRAFT = ("atlantiksolar-as2", "atlantiksolar-design", "sky-sailor")
MODELS = (SolarModel("CAM"), SolarModel("CAM", "report"), SolarModel("CDM"))
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


def climbs() -> Table:
    """What climbing gains AtlantikSolar AS-2 at 47.6 N, 536 m, in standard air."""
    aircraft = load_aircraft("atlantiksolar-as2")
    rows = []
    for date, ceiling_m in CLIMBS:
        climb = f"climb={{ceiling_m: {ceiling_m}}}"
        mission = load_mission("rafz-july", [f"dates={{on: {date}}}", "air={}", climb])
        result = compare_with_constant(aircraft, performance(aircraft, mission))
        values = (
            result.altitude_m.max(axis=-1),
            result.stored_height_wh,
            result.gliding_h,
            result.constant.cycle.excess_time_h,
            result.performance.cycle.excess_time_h,
            result.gain_in_excess_time_h,
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
