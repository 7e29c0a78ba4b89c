"""Structure, drag and propulsion of the user's own: like shipped ones, they give the same."""

from math import pi

import numpy as np
import pytest

import missions
import sizing
import studies
from missions import InputError

MISSION = missions.load_mission("central-europe-summer", {"required_excess_time_h": 3.0})
NAME = "atlantiksolar-design"
LIFT = {"lift_coefficient": 1.0, "maximum_lift_coefficient": 1.4}
PARABOLIC = LIFT | {
    "profile_drag_coefficient": 0.012,
    "reference_reynolds": 2e5,
    "parasitic_drag_coefficient": 0.008,
}
CHAIN = "airframe.propulsion"


def _drag(lift, aspect_ratio, reynolds):
    return 0.012 * (reynolds / 2e5) ** -0.35 + 0.008 + lift**2 / (pi * 0.9 * aspect_ratio)


sizing.register_structure(
    "own law", lambda inputs: 0.3 * inputs.wingspan_m**1.5 * inputs.aspect_ratio**-0.25
)
sizing.register_drag("own polar", _drag)
sizing.register_propulsion_mass("own motor", lambda rated_w: 0.0011 * rated_w)
# Power-independent, as a chain of constants; then one that falls with the load.
sizing.register_propulsion_efficiency(
    "own chain", lambda power_w, airspeed, density: 0.6 + 0.0 * power_w * airspeed * density
)
sizing.register_propulsion_efficiency("loaded", lambda power_w, *_: 0.7 - 0.004 * power_w)

POWER_LAW = {
    "model": "power_law",
    "coefficient_kg": 0.3,
    "span_exponent": 1.5,
    "aspect_ratio_exponent": -0.25,
}
SHIPPED_AND_OWN = {
    "structure": (
        {"airframe.structure": POWER_LAW},
        {"airframe.structure": {"model": "own", "name": "own law"}},
    ),
    "drag": (
        {"airframe.aerodynamics": PARABOLIC},
        {"airframe.aerodynamics": {"model": "own", "name": "own polar"} | LIFT},
    ),
    "propulsion": (
        {f"{CHAIN}.mass_kg_per_w": 0.0011},
        {f"{CHAIN}.mass_model": "own motor", f"{CHAIN}.mass_kg_per_w": 0.5},
    ),
    "efficiency": (
        {f"{CHAIN}.{link}_efficiency": 1.0 for link in ("controller", "gearbox")}
        | {f"{CHAIN}.motor_efficiency": 0.75, f"{CHAIN}.propeller_efficiency": 0.8},
        {f"{CHAIN}.efficiency_model": "own chain"},
    ),
}


@pytest.mark.parametrize("of", SHIPPED_AND_OWN)
def test_a_model_written_like_a_shipped_one_gives_the_same(of):
    shipped, user_defined = (sizing.load_aircraft(NAME, changes) for changes in SHIPPED_AND_OWN[of])
    analysis, expected = (sizing.analyse(subject, MISSION) for subject in (user_defined, shipped))
    assert analysis.total_mass_kg == pytest.approx(expected.total_mass_kg, rel=1e-12)
    assert analysis.power_out_w == pytest.approx(expected.power_out_w, rel=1e-12)
    sized, best = (sizing.size(subject, MISSION, "min_mass") for subject in (user_defined, shipped))
    assert sized.feasible
    assert sized.result.objective_value == pytest.approx(best.result.objective_value, rel=1e-6)
    assert str(sized)
    assert sizing.analyse(sized.sized_aircraft(), MISSION).excess_time_h == pytest.approx(
        sized.scenarios()["excess_time_h"].min()
    )


def test_an_own_efficiency_follows_the_load_of_each_design():
    aircraft = sizing.load_aircraft(NAME, {"airframe.propulsion.efficiency_model": "loaded"})
    for payload_kg in (0.0, 2.0):
        mission = missions.load_mission("rafz-july", {"payload.mass_kg": payload_kg})
        analysis = sizing.analyse(aircraft, mission)
        thrust_w = analysis.power_budget.watts["aerodynamic_w"]
        efficiency = thrust_w / analysis.propulsion_power_w
        assert efficiency == pytest.approx(0.7 - 0.004 * thrust_w, rel=1e-9)


def test_an_own_structure_sees_what_it_carries():
    seen = []

    def watched(inputs):
        seen.append(inputs)
        return 0.1 * inputs.total_mass_kg

    sizing.register_structure("a tenth", watched)
    aircraft = sizing.load_aircraft(
        NAME, {"airframe.structure": {"model": "own", "name": "a tenth"}}
    )
    analysis = sizing.analyse(aircraft, MISSION)
    assert analysis.masses_kg["structure"] == pytest.approx(0.1 * analysis.total_mass_kg)
    assert np.all(np.asarray(seen[-1].wingspan_m) == 5.65)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("structure", {"model": "own", "name": "unheard of"}),
        ("aerodynamics", PARABOLIC | {"model": "own", "name": "unheard of"}),
        ("propulsion.mass_model", "unheard of"),
        ("propulsion.efficiency_model", "unheard of"),
    ],
)
def test_a_name_that_nobody_registered_is_refused(key, value):
    with pytest.raises(InputError, match=r"'unheard of' is not registered by sizing\.register_"):
        sizing.load_aircraft(NAME, {f"airframe.{key}": value})
    with pytest.raises(ValueError, match="there is a drag model own polar already"):
        sizing.register_drag("own polar", _drag)


def test_wires_need_the_drag_of_a_shipped_polar():
    wires = {"attachment_span_fraction": 0.4, "angle_deg": 15.0}
    structure = {"model": "rib_wing", "calibration": 1.188, "bracing": wires}
    _, user_defined = SHIPPED_AND_OWN["drag"]
    with pytest.raises(InputError, match="parabolic or wing_polar"):
        sizing.load_aircraft(NAME, {"airframe.structure": structure} | user_defined)


_BAD = {
    "structure": (sizing.register_structure, "structure", lambda inputs: -1.0),
    "structure of NaN": (sizing.register_structure, "structure", lambda inputs: float("nan")),
    "drag": (sizing.register_drag, "aerodynamics", lambda lift, ratio, reynolds: -0.02),
    "propulsion_mass": (sizing.register_propulsion_mass, "mass_model", lambda rated_w: -0.1),
    "propulsion_efficiency": (
        sizing.register_propulsion_efficiency,
        "efficiency_model",
        lambda power_w, airspeed, density: 62.0,  # per cent
    ),
}


@pytest.mark.parametrize("kind", _BAD)
def test_functions_that_give_what_cannot_be_are_named(kind):
    register, key, function = _BAD[kind]
    name = f"bad {kind}"
    register(name, function)
    value = {"model": "own", "name": name}
    if key == "aerodynamics":
        value |= LIFT
    key = f"propulsion.{key}" if key.endswith("model") else key
    value = name if key.startswith("propulsion") else value
    aircraft = sizing.load_aircraft(NAME, {f"airframe.{key}": value})
    message = rf"function '{name}' of sizing\.{register.__name__} gives .* must be above 0"
    for study in (
        lambda: sizing.analyse(aircraft, MISSION),
        lambda: sizing.size(aircraft, MISSION),
        lambda: studies.sweep(aircraft, MISSION, {"battery_mass_kg": [2.0, 3.0]}),
        lambda: studies.feasibility_map(aircraft, MISSION, latitudes=[45], days=[170]),
    ):
        with pytest.raises(ValueError, match=message):
            study()
