"""Tests of the propulsion over load and voltage, against the exact chain point by point."""

from dataclasses import replace

import numpy as np
import pytest
from propulsors import VOLTAGE, aircraft
from scipy.integrate import solve_ivp
from weather_files import clear_record

import sizing
from missions.air import air_at
from missions.library import load_mission
from missions.weather.files import mission_at_site
from sizing.day.light import solar_day
from sizing.day.record import weather_performance
from sizing.design import DesignVariables, FlightConditions
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.performance import performance, performance_of_designs
from solar.sun import declination, sun_times

MISSION = load_mission("rafz-july")
CONTROLLER = {
    "resistance_ohm": 0.02,
    "freewheel_voltage_v": 0.7,
    "switching_loss": 0.005,
    "idle_power_w": 0.2,
}


def atlantiksolar(voltage=VOLTAGE, **parts):
    own = aircraft(voltage=voltage, controller=CONTROLLER, **parts)
    return own


AIRCRAFT = {"atlantiksolar": atlantiksolar(), "twin-boom": sizing.load_aircraft("twin-boom-design")}


def rough(all_day=0.0, thermal=0.0):
    turbulence = MISSION.turbulence.model_copy(update={"all_day": all_day, "thermal": thermal})
    return MISSION.model_copy(update={"turbulence": turbulence})


def exact_w(own, mission, load, bus_v):
    """Electric power of all propulsors by the public function, at the flight of the design."""
    design = design_of(own, mission)
    parts = getattr(own.airframe, "propulsion", None)
    speed = float(design.airspeed_m_per_s)
    thrust_n = float(design.propulsion_power_w) * design.chain.efficiency / speed * load
    air = FlightConditions.of(mission, own).air
    point = sizing.operating_point(parts.propulsor, thrust_n / parts.propulsors, speed, air, bus_v)
    assert np.all(point.feasible), point.reason
    return parts.propulsors * point.bus_power_w


def half_charged_v(own):
    """Voltage that days are flown by."""
    return own.battery.bus_voltage_v(np.array(0.5))


@pytest.mark.parametrize("name", list(AIRCRAFT))
def test_the_load_is_that_of_the_exact_chain(name):
    own, mission = AIRCRAFT[name], rough(0.05, 0.3)
    flown = performance(own, mission)
    hour, day = flown.day.time_h, flown.day
    half = (day.sunset_h[0] - day.sunrise_h[0]) / 2.0
    thermal = np.maximum(1.0 - np.abs(hour - 12.0) / half, 0.0)
    power_w = exact_w(own, mission, 1.05 + 0.3 * thermal, half_charged_v(own))
    # The table is 1e-5 off at the most.
    assert flown.load_w[0] - flown.design.constant_power_w == pytest.approx(power_w, rel=2e-5)


@pytest.mark.parametrize("name", list(AIRCRAFT))
def test_the_excess_time_is_how_long_the_battery_lasts(name):
    own, mission = AIRCRAFT[name], rough(0.1)
    flown = performance(own, mission)
    energy_wh, constant_w = float(flown.design.battery_energy_wh), flown.design.constant_power_w
    dawn_h = float(flown.cycle.equal_power_morning_h[0])
    at_dawn = float(np.interp(dawn_h, flown.cycle.time_h, flown.cycle.energy_wh[0])) / energy_wh

    def falls(_, __):
        load_w = exact_w(own, mission, np.array([1.1]), half_charged_v(own)) + constant_w
        return -load_w / own.battery.mean_discharge_efficiency / energy_wh

    def empty(_, charge):
        return float(charge[0])

    empty.terminal = True  # type: ignore[attr-defined]  # of solve_ivp
    lasts = solve_ivp(falls, (0.0, 24.0), [at_dawn], events=empty, rtol=1e-5, atol=1e-7)
    # The charge between two nodes of the day is not quite linear; the integral is off by 2e-4 h.
    assert float(flown.cycle.excess_time_h[0]) == pytest.approx(float(lasts.t[-1]), abs=2e-3)


@pytest.mark.parametrize(("climb", "within"), [(None, 0.0), ({"ceiling_m": 1536.0}, 1e-7)])
def test_a_design_does_not_depend_on_its_batch(climb, within):
    own = AIRCRAFT["twin-boom"]
    mission = load_mission("rafz-july", {"turbulence": rough(0.1, 0.3).turbulence, "climb": climb})
    spans = np.array([4.4, 4.8, 5.2])
    day = solar_day(own, mission)

    def flown(span):
        variables = DesignVariables(span, 15.0, 2.6, 1.0)
        return performance_of_designs(own, mission, variables, day=day).cycle

    batch = flown(spans)
    for place, span in enumerate(spans):
        one = flown(np.array([span]))
        assert one.excess_time_h[0] == pytest.approx(batch.excess_time_h[place], abs=within)
        charge = batch.minimum_state_of_charge[place]
        assert one.minimum_state_of_charge[0] == pytest.approx(charge, abs=within)


def test_thermals_beyond_the_propeller_have_a_reason(tmp_path):
    # Thrust of one curve up to an advance ratio whose speed level flight just needs.
    table = tmp_path / "narrow.csv"
    table.write_text(
        "# diameter_m: 0.66\nJ,CT,CP,rpm\n0.5,0.09,0.06,1000\n0.7,0.06,0.05,1000\n"
        "0.9,0.03,0.035,1000\n"
    )
    own = atlantiksolar(propeller={"table": str(table), "any_speed": True})
    assert performance(own, MISSION).cycle.perpetual.all()
    with pytest.raises(ImpossibleDesignError, match=r"6 times .* of rafz-july: thrust .* is above"):
        performance(own, rough(0.0, 5.0))


def test_parts_beyond_their_limits_are_told():
    motor = {
        "speed_constant_rpm_per_v": 317.0,
        "resistance_ohm": 0.299,
        "no_load_current_a": 0.137,
        "maximum_current_a": 3.0,
        "mass_kg": 0.48,
    }
    analysis = sizing.analyse(atlantiksolar(motor=motor), rough(0.0, 1.0))
    assert analysis.to_dict()["beyond_parts"].startswith("motor current")
    assert "beyond the parts: motor current" in " ".join(str(analysis.at_level(2)).split())
    # Level flight alone is within them.
    assert "beyond_parts" not in sizing.analyse(atlantiksolar(motor=motor), rough()).to_dict()


@pytest.mark.parametrize("name", list(AIRCRAFT))
def test_a_record_has_the_load_of_its_air(name):
    own, record = AIRCRAFT[name], clear_record(2, first="2001-07-14", interval_s=600.0)
    record = replace(record, temperature_c=12.0 + 14.0 * np.linspace(0.0, 1.0, len(record.start_s)))
    mission, _ = mission_at_site(rough(0.05, 0.3), record, chosen=False)
    done = weather_performance(own, mission, record)
    run, design = done.recorded, done.design
    parts = getattr(own.airframe, "propulsion", None)
    thrust_w = float(design.propulsion_power_w) * design.chain.efficiency
    assumed = mission.air_state()
    air_c = done.days.ambient_c
    for node in (20, 150, 200):
        day, at = 1, node
        warm_k = float(air_c[run.axis.nodes[day, at]]) + 273.15
        faster = np.sqrt(warm_k / float(assumed.temperature_k))
        speed = float(design.airspeed_m_per_s) * faster
        hour, light = run.axis.time_h[at] + run.axis.midnight_h[day], done.days.light
        rise = sun_times(light.site.latitude_deg, declination(run.axis.day_of_year[day] + 0.5))
        half = float(rise.sunset_h - rise.sunrise_h) / 2.0
        load = 1.05 + 0.3 * max(1.0 - abs(hour - 12.0) / half, 0.0)
        bus_v = half_charged_v(own)
        thrust_n = thrust_w * faster * load / speed / parts.propulsors
        air = air_at(warm_k, assumed.pressure_pa)
        point = sizing.operating_point(parts.propulsor, thrust_n, speed, air, bus_v)
        power_w = parts.propulsors * float(point.bus_power_w)
        heater_w = run.load_w[day, at] - power_w - float(design.constant_power_w)
        assert heater_w == pytest.approx(0.0, abs=3e-5 * power_w)
