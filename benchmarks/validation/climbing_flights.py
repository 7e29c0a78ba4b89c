"""Flights that climbed by day, flown by the model with what is known of their aircraft.

``python -m benchmarks.validation.climbing_flights`` prints the table of ``docs/altitude.md``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from missions.mission import Mission
from sizing import analyse, load_aircraft
from sizing.aircraft import Aircraft
from sizing.mass_budget import with_total_mass

_UNFAVOURABLE, _FAVOURABLE = 0, 1


def flights() -> dict[str, dict[str, Any]]:
    """Published flights by their names."""
    text = Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8")
    return dict(yaml.safe_load(text)["flights"])


def flown(given: dict[str, Any], end: int, *, climbs: bool = True) -> tuple[float, float]:
    """Excess time and reached altitude with all unknown inputs at one of their ends [h, m]."""
    value = {key: one[end] if isinstance(one, list) else one for key, one in given.items()}
    span, area = value["wingspan_m"], value["wing_area_m2"]
    specific = value["battery_wh"] / value["battery_mass_kg"]
    data = load_aircraft("stratosphere-design").model_dump(by_alias=True, exclude_unset=True)
    data["airframe"] |= {"wingspan_m": span, "aspect_ratio": span**2 / area}
    data["airframe"]["aerodynamics"] |= {
        "lift_coefficient": value["lift"],
        "profile_drag_coefficient": value["profile_drag"],
        "reynolds_exponent": 0.0,
        "parasitic_drag_coefficient": value["parasitic_drag"],
    }
    data["airframe"]["propulsion"] |= {
        "controller_efficiency": 1.0,
        "motor_efficiency": 1.0,
        "propeller_efficiency": value["propulsion"],
        "mass_kg_per_w": 0.0,
    }
    data["airframe"]["structure"] = {"model": "spar"}
    data["airframe"]["avionics_mass_kg"] = 0.0
    # Modules on tail and fuselage count as more efficient ones on the wing.
    on_wing = min(value["module_area_m2"], area)
    data["modules"] |= {
        "area_m2": on_wing,
        "efficiency_stc": value["module_efficiency"] * value["module_area_m2"] / on_wing,
        "mass_kg_per_m2": 0.0,
    }
    data["battery"] |= {
        "mass_kg": value["battery_mass_kg"],
        "specific_energy_wh_per_kg": specific,
    }
    data["power"]["avionics_w"] = value["constant_w"]
    mission = Mission.model_validate(
        {
            "name": "climbs",
            "latitude_deg": value["latitude_deg"],
            "dates": {"on": value["day"]},
            "altitude_m": value["floor_m"],
            **({"climb": {"ceiling_m": value["ceiling_m"]}} if climbs else {}),
        }
    )
    aircraft = with_total_mass(Aircraft.model_validate(data), mission, value["total_mass_kg"])
    found = analyse(aircraft, mission, replay=False)
    reached = value["floor_m"] if found.climb is None else found.climb.altitude_m[0].max()
    return float(found.performance.cycle.excess_time_h[0]), float(reached)


def answer(given: dict[str, Any]) -> str:
    """Whether the model repeats the day: for all, some or none of the unknown inputs."""
    ends = [flown(given, end)[0] > 0.0 for end in (_UNFAVOURABLE, _FAVOURABLE)]
    if all(ends):
        return "yes"
    return "for a part of what is unknown" if any(ends) else "no"


def main() -> None:
    """Print the table."""
    print("| flight | nights | excess time [h] | without climbs [h] | a repeated day? |")
    print("| --- | ---: | --- | --- | --- |")
    for given in flights().values():
        columns = []
        for climbs in (True, False):
            ends = [flown(given, end, climbs=climbs)[0] for end in (0, 1)]
            columns.append(" to ".join(f"{one:.1f}" for one in ends))
        print(f"| {given['name']} | {given['nights']} | {' | '.join(columns)} | {answer(given)} |")


if __name__ == "__main__":
    main()
