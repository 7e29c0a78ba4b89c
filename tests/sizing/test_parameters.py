"""The catalogue of parameters: every key is one of a file, and nothing is called by two units."""

import re
from functools import cache

import pytest

from missions.library import load_mission
from sizing.design import DesignVariables
from sizing.library import load_aircraft
from sizing.limits import QUANTITIES
from sizing.parameters import MISSION_PREFIX, catalogue, label, parameter, parameter_value, unit

# How names end in this software, and the unit that this stands for.
_ENDINGS = {
    "_rpm_per_v": "rpm/V",
    "_wh_per_kg": "Wh/kg",
    "_kg_per_m2": "kg/m2",
    "_kg_per_w": "kg/W",
    "_m_per_s": "m/s",
    "_w_per_k": "W/K",
    "_per_k": "1/K",
    "_per_h": "1/h",
    "_wh": "Wh",
    "_kg": "kg",
    "_m2": "m2",
    "_pa": "Pa",
    "_deg": "deg",
    "_days": "days",
    ".months": "months",
    "_k": "K",
    "_c": "C",
    "_m": "m",
    "_w": "W",
    "_h": "h",
}


@cache
def aircraft():
    common = [
        "design_space.maximum_total_mass_kg=50",
        "battery.temperature={held_c: 5, heat_loss_w_per_k: 0.4, heater_power_w: 9}",
        "battery.resistance={loss_at_1c: 0.05, discharge_rate_per_h: 0.1, charge_rate_per_h: 0.2}",
        "battery.ageing={}",
    ]
    limits = {"tip_deflection": 0.1, "tip_slope_deg": 10.0, "landing_deflection": 0.1}
    stiffness = [f"airframe.structure.maximum_{key}={value}" for key, value in limits.items()]
    return [
        load_aircraft("atlantiksolar-design", [*common, *stiffness]),
        load_aircraft("sky-sailor", common),
    ]


@pytest.mark.parametrize("one", catalogue().values(), ids=lambda one: one.key)
def test_units_are_those_of_the_names(one):
    name = one.key.removesuffix(".maximum")
    ends = (text for ending, text in _ENDINGS.items() if name.endswith(ending))
    assert one.unit == next(ends, "1")
    assert one.minimum < one.maximum
    assert one.label
    assert one.label == one.label.strip()


# Of a propulsion at its operating point and of a tail, which one shipped aircraft has.
OF_PARTS = re.compile(
    r"airframe\.(tail\.horizontal_volume|propulsion\.("
    r"(efficiency|motor_mass|propeller_mass)_factor|propeller\.(diameter|pitch)_m|gear\.ratio"
    r"|motor\.speed_constant_rpm_per_v))"
)


@pytest.mark.parametrize("one", catalogue().values(), ids=lambda one: one.key)
def test_keys_are_those_of_files_or_of_quantities(one):
    if one.kind == "quantity":
        others = {"worst_excess_time_h", "season_days", "latitude_band_deg", "endurance_h"}
        assert one.key in QUANTITIES or one.key in others
        return
    assert (one.kind == "mission") == one.key.startswith(MISSION_PREFIX)
    missions = [load_mission("rafz-july"), load_mission("central-europe-summer")]
    if OF_PARTS.fullmatch(one.key):
        # Its motor is one of the catalogue; constants of one's own are keys.
        motor = {"speed_constant_rpm_per_v": 300.0, "resistance_ohm": 0.1, "no_load_current_a": 0.2}
        with_motor = load_aircraft("twin-boom-design", {"airframe.propulsion.motor": motor})
        assert parameter_value(with_motor, None, one.key) is not None
        return
    values = [parameter_value(a, m, one.key) for a in aircraft() for m in missions]
    # Parts of one polar or structure are not in the other.
    if one.key not in (
        "airframe.propulsion.climb_rate_m_per_s",
        "airframe.propulsion.fixed_mass_kg",
        "airframe.aerodynamics.calibration",
        "airframe.structure.manoeuvre_load_factor",
        "mission.climb.ceiling_m",
    ):
        assert any(value is not None for value in values)


def test_every_limit_and_design_variable_is_in_the_catalogue():
    assert {parameter(name).kind for name in QUANTITIES} == {"quantity"}
    for name in DesignVariables._fields:
        assert parameter(name).name == name


def test_lookup_by_key_or_name():
    assert parameter("battery_mass_kg") is parameter("battery.mass_kg")
    assert label("battery.mass_kg") == "battery mass"
    assert unit("modules.mass_kg_per_m2") == "kg/m2"
    with pytest.raises(KeyError, match="no wing_span"):
        parameter("wing_span")


def test_sensible_ranges_hold_the_shipped_aircraft():
    for row in catalogue().values():
        for subject in aircraft():
            value = parameter_value(subject, load_mission("rafz-july"), row.key)
            if value is not None and row.kind != "quantity":
                assert row.minimum <= value <= row.maximum, row.key
