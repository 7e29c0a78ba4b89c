"""Days from an empty battery: counted against flying them, against formulas, and their limits."""

from __future__ import annotations

from math import ceil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from missions.mission import Scenarios
from sizing.energy.battery import Battery, ChargeLimit, NoChargeLimit, RuleChargeLimit, Store
from sizing.energy.cycle import Cycle, Status, simulate_cycle
from sizing.energy.settling import MAXIMUM_DAYS, SETTLED, days_to_settle, simulate_days
from sizing.sunlight import day_axis_h
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell
from solar.types import FloatArray

TIME = day_axis_h(0.25)
LOAD_W = 42.0


def store(energy_wh: float, limit: ChargeLimit | None = None) -> Store:
    battery = Battery(
        mass_kg=1.0,
        specific_energy_wh_per_kg=energy_wh,
        charge_limit=NoChargeLimit() if limit is None else limit,
    )
    return Store.of(battery)


def sun(latitude: float, day: float, share: float = 1.0) -> FloatArray:
    """Power of 1.35 m2 of modules [W] on a day at a latitude, under a share of the clear sky."""
    noon = Scenarios(np.array([latitude]), np.array([day])).noon_day
    return (
        1.35
        * share
        * horizontal_specific_power(
            latitude, noon, TIME, cell=SolarCell(), module_temperature_c=25.0, altitude_m=500.0
        )
    )


def flown(count: int, power: FloatArray, battery: Store) -> Cycle:
    """So many identical days."""
    return simulate_days(TIME, [power] * (count + 1), [LOAD_W] * (count + 1), battery)


def morning_wh(cycle: Cycle, battery: Store) -> float:
    """Energy at the morning's equal power: that of the excess time, none where it is negative."""
    return float(max(cycle.excess_time_h, 0.0) * LOAD_W / battery.discharge_efficiency)


batteries = st.builds(
    store,
    st.floats(300.0, 1200.0),
    st.sampled_from([None, RuleChargeLimit(), RuleChargeLimit(c_rate_per_h=0.15)]),
)


@settings(max_examples=30)
@given(batteries, st.floats(0.0, 60.0), st.integers(60, 280), st.floats(0.5, 1.0))
def test_days_to_settle_are_those_that_must_be_flown(
    battery: Store, latitude: float, day: int, share: float
) -> None:
    power = sun(latitude, day, share)
    days = float(days_to_settle(TIME, power, LOAD_W, battery))
    if not days <= 60:
        return
    end = morning_wh(simulate_cycle(TIME, power, LOAD_W, battery), battery)
    allowed = SETTLED * float(battery.battery_energy_wh)
    assert end - morning_wh(flown(int(days), power, battery), battery) <= allowed * (1 + 1e-6)
    if days > 1:
        before = morning_wh(flown(int(days) - 1, power, battery), battery)
        assert end - before > allowed * (1 - 1e-6)


@settings(max_examples=30)
@given(batteries, st.floats(0.0, 60.0), st.integers(60, 280), st.floats(0.5, 1.0))
def test_excess_time_rises_from_day_to_day_up_to_the_repeated_day(
    battery: Store, latitude: float, day: int, share: float
) -> None:
    power = sun(latitude, day, share)
    repeated = simulate_cycle(TIME, power, LOAD_W, battery)
    hours = [float(flown(n, power, battery).excess_time_h) for n in (1, 2, 3, 5)]
    assert np.all(np.diff([*hours, float(repeated.excess_time_h)]) >= -1e-8)
    if hours[0] > 0.0 and days_to_settle(TIME, power, LOAD_W, battery) == 1.0:
        near = SETTLED * battery.battery_energy_wh * battery.discharge_efficiency / LOAD_W
        assert hours[1] == pytest.approx(float(repeated.excess_time_h), abs=float(near))


def test_two_days_that_fill_the_battery_are_the_repeated_day() -> None:
    battery, power = store(732.0, RuleChargeLimit()), sun(47.6, 172)
    two, repeated = flown(2, power, battery), simulate_cycle(TIME, power, LOAD_W, battery)
    assert repeated.full_charge_h < 24.0
    for name in (
        "excess_time_h",
        "minimum_state_of_charge",
        "charge_margin_h",
        "equal_power_morning_h",
        "full_charge_h",
        "status",
        "energy_wh",
    ):
        assert getattr(two, name) == pytest.approx(getattr(repeated, name), abs=1e-8)


@settings(max_examples=30)
@given(batteries, st.floats(-70.0, 70.0), st.integers(1, 360), st.integers(1, 4))
def test_energy_is_conserved_while_the_date_advances(
    battery: Store, latitude: float, day: int, count: int
) -> None:
    powers = [sun(latitude, day + n) for n in range(count + 1)]
    cycle = simulate_days(TIME, powers, [LOAD_W] * len(powers), battery)
    budget = cycle.energy_budget
    stored = cycle.energy_wh[-1] - cycle.energy_wh[0]
    assert budget.stored_wh == pytest.approx(stored, abs=1e-6)
    assert budget.solar_wh + budget.unserved_wh == pytest.approx(
        budget.load_wh
        + budget.stored_wh
        + budget.charge_loss_wh
        + budget.discharge_loss_wh
        + budget.curtailed_wh,
        abs=1e-6,
    )


@pytest.mark.parametrize("gain_wh", [0.0, 3.0, 20.0, 200.0])
def test_days_of_equal_gains_are_counted_by_hand(gain_wh: float) -> None:
    battery = store(1000.0)
    # Constant power from 6 to 18 h that stores what 12 dark hours take, and some more.
    night_wh = 12.0 * LOAD_W / battery.discharge_efficiency
    surplus_w = (night_wh + gain_wh) / battery.charge_efficiency / 12.0
    power = np.where((TIME >= 6.0) & (TIME <= 18.0), LOAD_W + surplus_w, 0.0)
    first, second = (morning_wh(flown(n, power, battery), battery) for n in (1, 2))
    end = morning_wh(simulate_cycle(TIME, power, LOAD_W, battery), battery)
    # So much on the first morning, and the same more on each that follows, until it is full.
    expected = 1 + ceil((end - SETTLED * 1000.0 - first) / (second - first) - 1e-9)
    assert days_to_settle(TIME, power, LOAD_W, battery) == expected


def test_a_gain_next_to_nothing_takes_more_than_a_year() -> None:
    battery = store(1000.0)
    # A little above the share of the sun at which the day no longer pays for the night.
    lower, upper = 0.0, 1.0
    for _ in range(40):
        middle = (lower + upper) / 2.0
        cycle = simulate_cycle(TIME, sun(47.6, 172, middle), LOAD_W, battery)
        lower, upper = (lower, middle) if cycle.excess_time_h > 0.0 else (middle, upper)
    slow, quick = (
        days_to_settle(TIME, sun(47.6, 172, share), LOAD_W, battery)
        for share in (upper * (1.0 + 1e-6), upper * 1.01)
    )
    assert np.isinf(slow)
    assert 2 < quick < MAXIMUM_DAYS


def test_no_equal_power_is_nothing_to_settle() -> None:
    battery = store(500.0)
    polar_day, polar_night = np.full_like(TIME, 100.0), np.zeros_like(TIME)
    powers = np.stack([polar_day, polar_night, sun(47.6, 172)])
    assert np.isnan(days_to_settle(TIME, powers, LOAD_W, battery)).tolist() == [True, True, False]
    cycle = simulate_days(TIME, [powers] * 3, [LOAD_W] * 3, battery)
    assert cycle.status[:2].tolist() == [Status.always_lit, Status.never_lit]
    assert cycle.excess_time_h[1] == pytest.approx(-24.0)


def test_what_becomes_of_an_element_does_not_depend_on_the_others() -> None:
    battery = store(732.0, RuleChargeLimit())
    powers = np.stack([sun(47.6, day, 0.72) for day in range(60, 280, 20)])
    together = days_to_settle(TIME, powers, LOAD_W, battery)
    alone = [float(days_to_settle(TIME, power, LOAD_W, battery)) for power in powers]
    assert together.tolist() == alone
    days = [powers, powers * 0.99, powers * 0.98]
    both = simulate_days(TIME, days, [LOAD_W] * 3, battery)
    one = simulate_days(TIME, [day[3] for day in days], [LOAD_W] * 3, battery)
    assert both.excess_time_h[3] == one.excess_time_h


def test_a_flight_needs_a_day() -> None:
    with pytest.raises(ValueError, match=r"at least two dates are needed \(got 1\)"):
        simulate_days(TIME, [sun(47.6, 172)], [LOAD_W], store(500.0))
