"""The repeated day with derivatives: the simulator's numbers, and slopes as differences show them.

Regimes are told apart by what the simulator finds: charge margin above 0 where the day fills the
battery, excess time below 0 where it runs empty.
"""

from __future__ import annotations

import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft, mission

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.mass_budget import ImpossibleDesignError
from sizing.optimisation.repeated_day import DAY_OUTPUTS, DesignInDays, Regime
from sizing.performance import performance
from sizing.sunlight import solar_day
from solar.types import FloatArray

EVERYWHERE = mission(
    latitude_deg={"from_deg": 0.0, "to_deg": 60.0, "count": 4},
    dates={"from": "01-10", "to": "12-01", "count": 9},
    turbulence={"all_day": 0.1, "thermal": 0.05},
)
SUMMER = mission(dates={"on": "08-20"})
TABLE = aircraft(
    "atlantiksolar-design",
    "battery.charge_limit={kind: table, state_of_charge: [0, 0.8, 0.95, 1.0], "
    "current_a: [10.0, 10.0, 3.0, 0.5], voltage_v: 22, pack_energy_wh: 700}",
)
SLOW = aircraft(
    "atlantiksolar-design",
    "battery.charge_limit={kind: rule, c_rate_per_h: 0.12, taper_start: 0.5, "
    "relative_rate_at_full: 0.02}",
)
TECHNOLOGY = (
    "airframe.aerodynamics.parasitic_drag_coefficient",
    "airframe.propulsion.motor_efficiency",
    "airframe.structure.calibration",
    "battery.charge_efficiency",
    "battery.discharge_efficiency",
    "battery.specific_energy_wh_per_kg",
    "modules.efficiency_stc",
    "modules.mass_kg_per_m2",
    "power.avionics_w",
)


def in_days(craft: Aircraft, place: Mission, *keys: str, required_h: float = 0.0) -> DesignInDays:
    return DesignInDays(craft, place, solar_day(craft, place), keys, required_h=required_h)


def own_values(function: DesignInDays) -> FloatArray:
    return np.array(list(function.inputs.values()))


def evaluated(function: DesignInDays, values: FloatArray) -> FloatArray:
    return function.results(values, function.solved(values))


@pytest.mark.parametrize(
    "craft",
    [DESIGN, SKY_SAILOR, TABLE, SLOW, aircraft(DESIGN.name, "battery.charge_limit={kind: none}")],
    ids=["rule", "sky-sailor", "table", "slow", "none"],
)
def test_days_are_those_of_the_simulator(craft: Aircraft) -> None:
    function = in_days(craft, EVERYWHERE)
    values = own_values(function)
    state = function.solved(values)
    results = function.results(values, state)
    simulated = performance(craft, EVERYWHERE)
    cycle, count = simulated.cycle, len(simulated.day.scenarios)
    days = dict(zip(DAY_OUTPUTS, results[len(function.scalars) :].reshape(-1, count), strict=True))
    assert results[0] == pytest.approx(simulated.design.total_mass_kg, rel=1e-12)
    assert results[1] == pytest.approx(simulated.design.airspeed_m_per_s, rel=1e-12)
    limited = np.array(state.regimes) == Regime.limited
    np.testing.assert_array_equal(limited, cycle.excess_time_h < 0.0)
    assert limited.any()
    assert not limited.all()
    # Nodes of the day are 10 min apart instead of 5.
    np.testing.assert_allclose(days["excess_time_h"], cycle.excess_time_h, atol=0.01)
    np.testing.assert_allclose(days["charge_margin_h"], cycle.charge_margin_h, atol=0.03)
    np.testing.assert_allclose(
        days["minimum_state_of_charge"], cycle.minimum_state_of_charge, atol=5e-4
    )


def with_area(craft: Aircraft, area_m2: float) -> Aircraft:
    modules = craft.modules.model_copy(update={"area_m2": area_m2})
    return craft.model_copy(update={"modules": modules})


# A battery of 2.9 kg that takes 24 h to fill is either filled partly or not charged enough.
@pytest.mark.parametrize(
    ("area_m2", "regime"),
    [
        (0.6, Regime.limited),
        (0.7, Regime.partly_filled),
        (1.2, Regime.partly_filled),
        (2.4, Regime.partly_filled),
        (2.7, Regime.limited),
    ],
)
def test_a_battery_that_is_filled_partly_is_that_of_the_simulator(
    area_m2: float, regime: Regime
) -> None:
    craft = with_area(SLOW, area_m2)
    function, cycle = in_days(craft, SUMMER), performance(craft, SUMMER).cycle
    values = own_values(function)
    state = function.solved(values)
    assert state.regimes == (regime,)
    excess_h, _, least = function.results(values, state)[len(function.scalars) :][:3]
    assert excess_h == pytest.approx(float(cycle.excess_time_h[0]), abs=0.01)
    assert least == pytest.approx(float(cycle.minimum_state_of_charge[0]), abs=5e-4)


@pytest.mark.parametrize(
    ("craft", "area_m2", "regime"),
    [
        (DESIGN, 1.3, Regime.filled),
        (TABLE, 1.3, Regime.filled),
        (SLOW, 1.2, Regime.partly_filled),
        (SLOW, 2.4, Regime.partly_filled),
        (DESIGN, 0.6, Regime.limited),
        (SLOW, 2.7, Regime.limited),
    ],
)
def test_slopes_are_those_of_differences(craft: Aircraft, area_m2: float, regime: Regime) -> None:
    function = in_days(with_area(craft, area_m2), SUMMER, *TECHNOLOGY, required_h=3.0)
    values = own_values(function)
    state = function.solved(values)
    assert state.regimes == (regime,)
    exact = function.jacobian(values, state)
    steps = 1e-6 * np.maximum(np.abs(values), 1.0)
    differences = [
        (evaluated(function, values + one) - evaluated(function, values - one)) / (2.0 * one.sum())
        for one in np.diag(steps)
    ]
    # What closing the mass and the day leaves, 1e-13, over the step; and the curvature of the
    # charge margin, whose slope changes between two nodes: 1e-6 by this step, 1e-4 by ten of it.
    scale = np.abs(exact).max(axis=1, keepdims=True)
    assert np.all(np.abs(exact - np.transpose(differences)) < 1e-5 * scale + 1e-6)


def test_a_day_without_a_night_counts_what_a_full_battery_carries() -> None:
    # The simulator's excess time is infinite there.
    place = mission(latitude_deg=80.0, dates={"on": "06-21"})
    craft = aircraft(DESIGN.name, "modules.area_m2=1.35", "power.avionics_w=1")
    perf = performance(craft, place)
    assert np.isinf(perf.cycle.excess_time_h).all()
    function = in_days(craft, place)
    excess_h = evaluated(function, own_values(function))[len(function.scalars)]
    usable_wh = perf.design.battery_energy_wh * craft.battery.discharge_efficiency
    assert excess_h == pytest.approx(usable_wh / float(perf.nominal_load_w[0]), rel=1e-9)


def test_a_day_without_sun_misses_all_its_hours() -> None:
    function = in_days(DESIGN, mission(latitude_deg=80.0, dates={"on": "12-21"}))
    values = own_values(function)
    results = evaluated(function, values)[len(function.scalars) :]
    np.testing.assert_allclose(results[:3], [-24.0, 0.0, 0.0], atol=1e-6)
    assert np.isfinite(function.jacobian(values, function.solved(values))).all()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(TypeError, match="is a measured aircraft"):
        in_days(AS2, SUMMER)
    for key in ("modules.mppt_efficiency", "airframe.wingspan_m", "no.such"):
        with pytest.raises(ValueError, match=f"{key} cannot be an input; these can: .*avionics_w"):
            in_days(DESIGN, SUMMER, key)
    function = in_days(DESIGN, SUMMER)
    values = own_values(function)
    values[list(function.inputs).index("battery_mass_kg")] = 1e5
    with pytest.raises(ImpossibleDesignError, match="cannot carry its own mass"):
        function.solved(values)
