"""Tables on altitude for the documentation: ceilings of the shipped aircraft, gains by climbing."""

from __future__ import annotations

from missions.library import load_mission
from sizing.altitude.ceiling import highest_perpetual_altitude
from sizing.altitude.climb_cycle import climb_performance
from sizing.library import load_aircraft
from sizing.sunlight import SolarModel

AIRCRAFT = ("atlantiksolar-as2", "atlantiksolar-design", "sky-sailor")
MODELS = (SolarModel("CAM"), SolarModel("CAM", "report"), SolarModel("CDM"))
# (date, strategy, ceiling [m]) of AtlantikSolar AS-2 at 47.6 N.
CLIMBS = (
    ("06-21", "battery_full", 1536),
    ("06-21", "battery_full", 3536),
    ("06-21", "battery_full", 6536),
    ("10-10", "battery_full", 3536),
    ("10-10", "surplus", 3536),
)


def ceilings() -> str:
    """Highest altitude of perpetual flight at 47.6 N on 21 June in standard air, as Markdown."""
    mission = load_mission("rafz-july", ["dates={on: 06-21}", "air={}"])
    lines = [
        "| aircraft | "
        + " | ".join(f"{m.model}, correction {m.correction}" for m in MODELS)
        + " |",
        "|---|" + "---|" * len(MODELS),
    ]
    for name in AIRCRAFT:
        aircraft = load_aircraft(name)
        heights = []
        for solar in MODELS:
            found = highest_perpetual_altitude(aircraft, mission, solar, step_m=1000.0)
            highest = found.highest
            heights.append("none" if highest is None else f"{highest.altitude_m:.0f} m")
        lines.append(f"| `{name}` | " + " | ".join(heights) + " |")
    return "\n".join(lines) + "\n"


def climbs() -> str:
    """What climbing gains AtlantikSolar AS-2 at 47.6 N, 536 m, in standard air, as Markdown."""
    aircraft = load_aircraft("atlantiksolar-as2")
    lines = [
        "| date | strategy | ceiling | reached | stored height | gliding | excess time at 536 m "
        "| with climb | gain |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for date, strategy, ceiling_m in CLIMBS:
        climb = f"climb={{ceiling_m: {ceiling_m}, strategy: {strategy}}}"
        mission = load_mission("rafz-july", [f"dates={{on: {date}}}", "air={}", climb])
        result = climb_performance(aircraft, mission)
        flown, level = result.climb, result.constant.cycle.excess_time_h[0]
        lines.append(
            f"| {date} | `{strategy}` | {ceiling_m} m | {flown.maximum_altitude_m[0]:.0f} m "
            f"| {flown.maximum_potential_energy_wh[0]:.1f} Wh | {flown.gliding_h[0]:.1f} h "
            f"| {level:.2f} h | {flown.cycle.excess_time_h[0]:.2f} h "
            f"| {abs(round(result.gain_h[0], 2)):.2f} h |"
        )
    return "\n".join(lines) + "\n"
