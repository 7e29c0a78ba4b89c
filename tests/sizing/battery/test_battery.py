"""Charge limits and the clock that follows them, against numerical integration of the rate."""

from math import log

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plain_days import rate_per_h
from pydantic import ValidationError
from scipy.integrate import solve_ivp

from missions.library import load_mission
from sizing.battery.battery import (
    Battery,
    NoChargeLimit,
    RuleChargeLimit,
    TableChargeLimit,
    charge_rate_per_h,
)
from sizing.day.battery import ChargeClock, Store
from sizing.library import load_aircraft
from sizing.mass_budget import design_of

RULE = RuleChargeLimit()
socs = st.floats(0.0, 1.0)
rules = st.builds(
    RuleChargeLimit,
    c_rate_per_h=st.floats(0.05, 5.0),
    taper_start=st.floats(0.0, 0.95),
    relative_rate_at_full=st.floats(0.01, 1.0),
)


@st.composite
def tables(draw):
    """Tables whose current falls with the state of charge, as chargers do."""
    count = draw(st.integers(2, 8))
    gaps = draw(st.lists(st.floats(0.01, 1.0), min_size=count, max_size=count))
    knots = np.cumsum(gaps) / sum(gaps) * draw(st.floats(0.3, 1.0))
    steps = draw(st.lists(st.floats(0.1, 5.0), min_size=count, max_size=count))
    return TableChargeLimit(
        state_of_charge=tuple(knots.tolist()),
        current_a=tuple(np.cumsum(steps)[::-1].tolist()),
        voltage_v=25.0,
        pack_energy_wh=700.0,
    )


limits = st.one_of(rules, tables())


def integrated(limit, start, hours):
    """State of charge after following the limit, by an adaptive integrator that stops at full."""

    def full(_, soc):
        return float(soc[0]) - 1.0

    full.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(
        lambda _, soc: [rate_per_h(limit, float(soc[0]))],
        (0.0, hours),
        [start],
        events=full,
        rtol=1e-9,
        atol=1e-11,
        max_step=0.02,
    )
    return min(float(solution.y[0, -1]), 1.0)


def test_rule_is_half_a_capacity_per_hour_up_to_ninety_percent():
    # The published rule: 0.5 C up to 90 %, then exponentially to 4.6 % of that at full charge.
    # Exact but for the rounding of exp and log.
    assert charge_rate_per_h(RULE, [0.0, 0.5, 0.9]) == pytest.approx([0.5, 0.5, 0.5], rel=1e-12)
    assert charge_rate_per_h(RULE, 1.0) == pytest.approx(0.5 * 0.046, rel=1e-12)
    # Exponential: half-way the rate is the geometric mean of its ends.
    assert charge_rate_per_h(RULE, 0.95) == pytest.approx(0.5 * 0.046**0.5, rel=1e-12)


@given(limit=limits, soc=socs)
def test_rate_equals_the_scalar_formula(limit, soc):
    # Same arithmetic in another order: rounding alone.
    assert float(charge_rate_per_h(limit, soc)) == pytest.approx(rate_per_h(limit, soc), rel=1e-9)


@pytest.mark.parametrize(
    ("soc", "current", "message"),
    [
        ((0.5, 0.9, 1.0), (5.0, 1.0), "same length"),
        ((0.9, 0.5), (5.0, 1.0), "increase strictly"),
        ((0.5, 0.5), (5.0, 1.0), "increase strictly"),
        ((0.5, 1.1), (5.0, 1.0), "less than or equal to 1"),
        ((0.5, 1.0), (5.0, 0.0), "greater than 0"),
        # Started empty, a charger that begins slowly is another one than started full.
        ((0.5, 1.0), (1.0, 5.0), "must not rise with the state of charge"),
    ],
)
def test_bad_tables_are_refused(soc, current, message):
    with pytest.raises(ValidationError, match=message):
        TableChargeLimit(
            state_of_charge=soc, current_a=current, voltage_v=25.0, pack_energy_wh=700.0
        )


@settings(max_examples=25, deadline=None)
@given(limit=limits, start=st.floats(0.0, 0.999), hours=st.floats(0.001, 3.0))
def test_any_clock_follows_its_limit(limit, start, hours):
    clock = ChargeClock.of(limit)
    charged = float(clock.after(np.asarray(start), hours))
    # The spacing of the table, 2.5e-4, squared times the steepest relative fall of the rate that
    # is drawn (ln 100 within 5 % of charge, so 92 per unit): (2.5e-4)^2 * 92 = 6e-6.
    assert charged == pytest.approx(integrated(limit, start, hours), abs=1e-5)


def test_clock_of_the_rule_in_closed_form():
    clock = ChargeClock.of(RULE)
    # At 0.5 C one hour charges half the battery: no approximation below the taper, only rounding.
    assert float(clock.after(np.asarray(0.1), 1.0)) == pytest.approx(0.6, abs=1e-12)
    # 0.9/0.5 h at constant current; the taper takes (1/r - 1) / (k 0.5 C), k = -ln r / 0.1.
    decay = -log(0.046) / 0.1
    expected = 1.8 + (1.0 / 0.046 - 1.0) / (decay * 0.5)
    # The trapezoidal rule's error, promised below 1e-6 h over the whole table.
    assert float(clock.hours_to_full(np.asarray(0.0))) == pytest.approx(expected, abs=1e-5)


@given(limit=limits, start=socs, first=st.floats(0.0, 5.0), second=st.floats(0.0, 5.0))
def test_two_steps_are_one_step(limit, start, first, second):
    clock = ChargeClock.of(limit)
    soc = np.asarray(start)
    at_once = clock.after(soc, first + second)
    in_turn = clock.after(clock.after(soc, first), second)
    # A shift along one table: the interpolations cancel exactly, rounding stays.
    assert float(in_turn) == pytest.approx(float(at_once), abs=1e-10)


@given(limit=limits, start=st.floats(0.0, 0.99))
def test_hours_to_full_is_when_the_clock_arrives(limit, start):
    clock = ChargeClock.of(limit)
    hours = float(clock.hours_to_full(np.asarray(start)))
    assume(hours > 1e-3)
    # Rounding of the table's sums.
    assert float(clock.after(np.asarray(start), hours)) == pytest.approx(1.0, abs=1e-9)
    assert float(clock.after(np.asarray(start), 0.9 * hours)) < 1.0


def test_charging_adds_the_constant_power_of_the_limit():
    # 0.2 of 800 Wh an hour is 160 W, whatever the sun leaves over; an hour and a half of it 240 Wh.
    limit = RuleChargeLimit(c_rate_per_h=0.2, taper_start=0.9, relative_rate_at_full=0.05)
    battery = Battery(
        mass_kg=4.0, specific_energy_wh_per_kg=200.0, charge_efficiency=0.9, charge_limit=limit
    )
    store = Store.of(battery)
    charged = store.charged(np.array([0.0, 100.0]), np.array([600.0, 500.0]), 1.5)
    assert charged == pytest.approx([240.0, 340.0], rel=1e-12)
    clock = ChargeClock.of(NoChargeLimit())  # charges at once
    assert clock.after(np.array([0.0, 0.3]), 1e-6) == pytest.approx([1.0, 1.0])
    assert clock.hours_to_full(np.array([0.0, 0.3])) == pytest.approx([0.0, 0.0])
    with pytest.raises(ValueError, match="no finite charge rate"):
        charge_rate_per_h(NoChargeLimit(), 0.5)
    # Less than that is stored as it comes, at the charge efficiency.
    assert store.charged(np.array([100.0]), np.array([50.0]), 1.5) == pytest.approx([145.0])


def test_below_the_floor_nothing_is_drawn():
    keys = {"mass_kg": 2.0, "specific_energy_wh_per_kg": 250.0}
    volts = {"cells_in_series": 6, "state_of_charge": [0, 1], "cell_voltage_v": [3.0, 4.0]}
    floor = Battery.model_validate({**keys, "minimum_state_of_charge": 0.2, "voltage": volts})
    assert floor.capacity_fraction(20.0) == pytest.approx(0.8)
    assert floor.ends_v == pytest.approx((6 * 3.2, 6 * 4.0))
    pack = {"cell": "samsung-50e", "minimum_state_of_charge": 0.2}
    window = {"cells_in_series": 6, "cells_in_parallel": 4, "minimum_state_of_charge": 0.1}
    with pytest.raises(ValidationError, match="give one floor"):
        Battery.model_validate({**pack, "pack": window})
    whole = {"cell": "amprius-sa03-pack", "mass_kg": 2.556, "minimum_state_of_charge": 0.2}
    assert Battery.model_validate(whole).capacity_fraction(20.0) == pytest.approx(0.8)


def test_a_flight_has_the_energy_above_the_floor():
    mission = load_mission("rafz-july")
    whole, kept = (
        design_of(load_aircraft("atlantiksolar-as2", changes), mission).battery_energy_wh
        for changes in ({}, {"battery.minimum_state_of_charge": 0.15})
    )
    assert kept == pytest.approx(0.85 * whole)
