import numpy as np
import pytest

import sizing
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.uncertainty import Normal
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.parameters import MISSION_PREFIX, parameter_value
from sizing.uncertainty.inputs import SOLAR_MODEL, UncertainInput, UncertainInputs, uncertain_inputs
from sizing.uncertainty.propagation import Propagation, check_inputs

DESIGN = {
    "battery.specific_energy_wh_per_kg": 0.04,
    "battery.charge_efficiency": 0.02,
    "modules.efficiency_stc": 0.05,
    "modules.mppt_efficiency": 0.005,
    "modules.camber_efficiency": 0.01,
    "modules.diffuse_efficiency": 0.05,
    "modules.temperature_coefficient_per_k": 0.2,
    "airframe.aerodynamics.profile_drag_coefficient": 0.08,
    "airframe.propulsion.propeller_efficiency": 0.03,
    "airframe.structure.calibration": 0.05,
    "power.avionics_w": 0.1,
    "mission.payload.mass_kg": 0.3,
    "mission.turbulence.all_day": 0.3,
}
MEASURED = {
    "battery.specific_energy_wh_per_kg": 0.04,
    "battery.discharge_efficiency": 0.01,
    "airframe.level_flight.electric_power_w": 0.1,
    "modules.efficiency_stc": 0.03,
    "mission.clearness": 0.1,
    "mission.turbulence.thermal": 0.4,
}
AGED = [
    "battery.temperature={held_c: 20, heat_loss_w_per_k: 0.3, ambient_offset_k: 2}",
    "battery.resistance={loss_at_1c: 0.05, discharge_rate_per_h: 0.06, charge_rate_per_h: 0.2}",
    "battery.ageing={cycles: 200, months: 6}",
]
BATTERY = {
    "battery.temperature.held_c": 0.1,
    "battery.temperature.ambient_offset_k": 0.5,
    "battery.temperature.heat_loss_w_per_k": 0.2,
    "battery.resistance.loss_at_1c": 0.2,
    "battery.ageing.cycles": 0.3,
    "battery.ageing.months": 0.3,
    "battery.ageing.depth_of_discharge": 0.1,
    "mission.air.ambient_temperature_c": 0.3,
}
MISSION = {"payload.mass_kg": 0.2, "turbulence": {"all_day": 0.1, "thermal": 0.2}, "clearness": 0.9}


def drawn(aircraft, mission, spreads, count=5):
    random = np.random.default_rng(7)
    return {
        key: parameter_value(aircraft, mission, key)
        * (1.0 + spread * np.clip(random.standard_normal(count), -2.0, 2.0))
        for key, spread in spreads.items()
    }


def alone(aircraft, mission, values, number):
    """Aircraft and mission of one draw, validated as a file's."""
    of_craft = {k: float(v[number]) for k, v in values.items() if not k.startswith(MISSION_PREFIX)}
    of_mission = {
        k.removeprefix(MISSION_PREFIX): float(v[number])
        for k, v in values.items()
        if k.startswith(MISSION_PREFIX)
    }
    return with_values(aircraft, of_craft), with_values(mission, of_mission)


@pytest.mark.parametrize(
    ("name", "spreads", "model"),
    [
        ("atlantiksolar-design", DESIGN, "CAM"),
        ("atlantiksolar-design", {k: v for k, v in DESIGN.items() if "diffuse" not in k}, "CDM"),
        ("atlantiksolar-design", {"modules.diffuse_efficiency": 0.05}, "CAM"),
        ("atlantiksolar-as2", MEASURED, "CAM"),
        ("atlantiksolar-design", BATTERY, "CAM"),
        ("atlantiksolar-as2", BATTERY, "CAM"),
    ],
)
def test_draws_are_what_each_is_alone(name, spreads, model):
    overrides = AGED if spreads is BATTERY else []
    aircraft = load_aircraft(name, overrides)
    cold = {"air": {"ambient_temperature_c": 10.0}} if overrides else {}
    mission = load_mission("central-europe-summer", MISSION | cold)
    values = drawn(aircraft, mission, spreads)
    flights = Propagation(aircraft, mission, SolarModel(model)).flights(values)
    for number in range(5):
        single_aircraft, where = alone(aircraft, mission, values, number)
        analysis = sizing.analyse(single_aircraft, where, model=model)
        # All draws have the warmth of the nominal modules above the air, a kelvin or so off.
        assert flights.excess_time_h[number] == pytest.approx(analysis.excess_time_h, abs=0.02)
        design = analysis.performance.design
        assert flights.total_mass_kg[number] == pytest.approx(design.total_mass_kg, rel=1e-8)


def test_the_models_error_is_a_factor_on_its_power():
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-july")
    study = Propagation(aircraft, mission, SolarModel())
    single = study.flights({SOLAR_MODEL: np.array([0.9])})
    other = study.flights({"mission.clearness": np.array([0.9])})
    assert single.excess_time_h == pytest.approx(other.excess_time_h, abs=1e-9)


def test_efficiencies_of_batteries_that_run_empty_scatter_too():
    aircraft = load_aircraft("atlantiksolar-design", {"battery.mass_kg": 1.2})
    mission = load_mission("rafz-july")
    keys = ("battery.charge_efficiency", "battery.discharge_efficiency")
    values = {key: np.array([0.9, 0.97, 0.99]) for key in keys}
    study = Propagation(aircraft, mission, SolarModel())
    flights, endurance = study.flights(values), study.endurance_h(values)
    for number in range(3):
        drawn, where = alone(aircraft, mission, values, number)
        analysis = sizing.analyse(drawn, where)
        assert flights.excess_time_h[number] < 0.0
        assert flights.excess_time_h[number] == pytest.approx(analysis.excess_time_h, abs=1e-6)
        assert endurance[number] == pytest.approx(analysis.endurance_h, abs=1e-6)


def scattering(key):
    return UncertainInputs((UncertainInput(key, 1.0, Normal(sigma=0.1)),), np.eye(1))


def test_attitude_models_take_efficiencies_and_refuse_what_is_not_linear():
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-loiter")
    study = Propagation(aircraft, mission, SolarModel("VM"))
    values = {"modules.efficiency_stc": np.array([0.22, 0.237])}
    drawn, where = alone(aircraft, mission, values, 0)
    alone_h = sizing.analyse(drawn, where, model="VM").excess_time_h
    assert study.flights(values).excess_time_h[0] == pytest.approx(alone_h, abs=1e-6)
    with pytest.raises(ValueError, match="varies with CDM and CAM alone"):
        check_inputs(scattering("modules.camber_efficiency"), mission, SolarModel("VM"))
    with pytest.raises(ValueError, match="moves the sun"):
        check_inputs(scattering("mission.latitude_deg"), mission, SolarModel("VM"))
    # Neither is refused what only both together would be.
    check_inputs(scattering("modules.camber_efficiency"), mission, SolarModel("CAM"))
    check_inputs(scattering("battery.specific_energy_wh_per_kg"), mission, SolarModel("VM"))


def test_what_draws_take_from_outside_is_what_each_alone_takes():
    aged = ["battery.temperature={}", "battery.ageing={cycles: 3000, months: 24}"]
    aircraft = load_aircraft("atlantiksolar-design", aged)
    mission = load_mission("rafz-july", {"air": {"ambient_temperature_c": -5.0}})
    spreads = {
        "battery.ageing.cycles": 0.5,
        "mission.air.ambient_temperature_c": 3.0,
        "airframe.aerodynamics.profile_drag_coefficient": 0.1,
    }
    values = drawn(aircraft, mission, spreads, count=24)
    solar = SolarModel("CAM", "report")
    study = Propagation(aircraft, mission, solar)
    noted = {note.quantity: note for note in study.extrapolations(values, study.flights(values))}
    by_quantity = {}
    for number in range(24):
        single_aircraft, where = alone(aircraft, mission, values, number)
        for note in sizing.analyse(single_aircraft, where, correction="report").extrapolations:
            by_quantity.setdefault(note.quantity, []).append(note)
    assert noted.keys() == by_quantity.keys() >= {"aged_capacity_fraction", "pack_temperature_c"}
    for quantity, each in by_quantity.items():
        worst = max(each, key=lambda note: note.distance)
        assert noted[quantity].value == pytest.approx(worst.value, rel=1e-8)
        if noted[quantity].of:  # the sun's height is one for all draws
            assert (noted[quantity].count, noted[quantity].of) == (len(each), 24)


def test_error_of_the_solar_model_is_an_input_of_its_own():
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-july")
    for name, rms in (("CDM", 0.2003), ("CAM", 0.0702)):
        inputs = uncertain_inputs(aircraft, mission, SolarModel(name)).inputs
        (error,) = (scattering for scattering in inputs if scattering.key == SOLAR_MODEL)
        assert error.nominal == 1.0
        assert error.values(np.array([0.8413]))[0] == pytest.approx(1.0 + rms, abs=1e-4)
