"""What alone makes a limited flight perpetual, against analyses of files with those values."""

from itertools import pairwise

import numpy as np
import pytest

import missions
import sizing

MISSION = missions.load_mission("rafz-july", ["latitude_deg=50", "dates.on=05-01"])
# Of a value that suffices: the scan is as fine as 0.1 %, and three digits are up to 1 % apart.
LESS = 0.985


def analysed(name, *overrides):
    return sizing.analyse(sizing.load_aircraft(name, overrides), MISSION)


def relaxed(name, *overrides):
    return {r.parameter: r for r in analysed(name, *overrides).relaxations}


def enough(name, key, present, value, *others):
    """Analysis of what just suffices; a little less of the change does not."""
    changes = (f"{key}={present + share * (value - present)}" for share in (1.0, LESS))
    whole, short = (analysed(name, change, *others) for change in changes)
    assert whole.is_perpetual
    assert not short.is_perpetual
    return whole


@pytest.mark.parametrize("name", ["atlantiksolar-as2", "sky-sailor"])
def test_a_battery_suffices_from_its_value_on(name):
    light_kg = 0.4 * sizing.load_aircraft(name).battery.mass_kg
    relaxation = relaxed(name, f"battery.mass_kg={light_kg:g}")["battery.mass_kg"]
    assert relaxation.direction == "at least"
    analysis = enough(name, "battery.mass_kg", 0.0, relaxation.value)
    # Another mass flies at another airspeed, which cools the modules of a measured aircraft.
    assert analysis.excess_time_h == pytest.approx(relaxation.excess_time_h, abs=2e-3)


def test_modules_weigh_what_they_weigh_and_avionics_take_what_they_take():
    few = "modules.area_m2=0.6"
    relaxation = relaxed("atlantiksolar-as2", few)["modules.area_m2"]
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    more_kg = aircraft.modules.mass_kg_per_m2 * (relaxation.value - 0.6)
    rest_kg = aircraft.airframe.mass_without_battery_kg  # type: ignore[union-attr]
    heavier = f"airframe.mass_without_battery_kg={rest_kg + more_kg}"
    analysis = analysed("atlantiksolar-as2", f"modules.area_m2={relaxation.value}", heavier)
    # But for the airspeed.
    assert analysis.excess_time_h == pytest.approx(relaxation.excess_time_h, abs=2e-3)
    heavy, area = "battery.mass_kg=4", "modules.area_m2"
    relaxation = relaxed("atlantiksolar-design", f"{area}=0.8", heavy)[area]
    enough("atlantiksolar-design", area, 0.0, relaxation.value, heavy)
    # A load may fall by what the avionics save.
    relaxation = relaxed("atlantiksolar-as2", "power.avionics_w=40")["load_w"]
    saved_w = (relaxation.present - relaxation.value) * aircraft.power.supply_efficiency
    enough("atlantiksolar-as2", "power.avionics_w", 40.0, 40.0 - saved_w)


def test_the_smallest_change_comes_first_and_two_are_shown():
    analysis = analysed("atlantiksolar-as2", "battery.mass_kg=1.2")
    changes = [relaxation.relative_change for relaxation in analysis.relaxations]
    assert len(changes) >= 2
    assert all(change <= following for change, following in pairwise(changes))
    text = str(analysis)
    assert "perpetual with one change: " in text
    assert "battery mass at least" in text


def flown_h(analysis, launch_h):
    """Flight time marched minute by minute from a full battery."""
    perf, battery = analysis.performance, analysis.aircraft.battery
    energy = full = float(perf.design.battery_energy_wh)
    clock, step = launch_h, 1.0 / 240.0
    while energy > 0.0:
        sun, load = (
            float(np.interp((clock + step / 2.0) % 24.0, perf.day.time_h, power[0]))
            for power in (perf.solar_power_w, perf.load_w)
        )
        net = (sun - load) * step
        gain = (
            battery.mean_charge_efficiency if net > 0.0 else 1.0 / battery.mean_discharge_efficiency
        )
        energy = min(energy + net * gain, full)
        clock += step
    return clock - launch_h


def test_flights_from_sunrise_and_noon_are_those_marched_by_the_minute():
    analysis = analysed(
        "atlantiksolar-as2", "battery.charge_limit={kind: none}", "power.avionics_w=30"
    )
    flight = analysis.limited_flight
    sunrise_h = float(analysis.performance.day.sunrise_h[0])
    assert flight.from_noon_h == pytest.approx(flown_h(analysis, 12.0), abs=0.02)
    assert flight.from_sunrise_h == pytest.approx(flown_h(analysis, sunrise_h), abs=0.02)
    assert flight.endurance_h >= max(flight.from_noon_h, flight.from_sunrise_h) - 1e-9
    # It ends by so much before the sun carries the load.
    dawn_h = float(analysis.performance.cycle.equal_power_morning_h[0])
    assert (flight.empty_h + flight.before_sun_h - dawn_h) % 24.0 == pytest.approx(0.0, abs=1e-9)


def test_a_perpetual_flight_needs_nothing_and_without_sun_no_launch_is_better():
    july = missions.load_mission("rafz-july")
    analysis = sizing.analyse(sizing.load_aircraft("atlantiksolar-as2"), july)
    assert analysis.relaxations == ()
    assert analysis.limited_flight is None
    assert "It flies perpetually, with an excess time of 6.27 h." in str(analysis)
    night = missions.load_mission("rafz-july", ["latitude_deg=80", "dates.on=12-01"])
    text = str(sizing.analyse(sizing.load_aircraft("atlantiksolar-as2"), night))
    assert "sunrise it flies" not in text
    assert "leaves the excess time at -24.00 h" in " ".join(text.split())
