"""Time marching of the battery: conservation, exact integrals, and brute-force repetition."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from step_by_step import balance_of, march

from sizing.battery.battery import Battery, NoChargeLimit, RuleChargeLimit, TableChargeLimit
from sizing.day.balance import PowerBalance, crossing_fraction, positive_part_wh, ramp_fraction
from sizing.day.battery import Store
from sizing.day.cycle import simulate_cycle
from sizing.day.march import ChargingDay
from solar.types import FloatArray

TABLE = TableChargeLimit(
    state_of_charge=(0.5, 0.8, 0.9, 0.99),
    current_a=(12.0, 8.0, 4.0, 0.6),
    voltage_v=25.0,
    pack_energy_wh=732.0,
)
LIMITS = [NoChargeLimit(), RuleChargeLimit(), TABLE]
powers = st.floats(-500.0, 500.0)


class Case(NamedTuple):
    """A random batch: time axis, solar power and load, and batteries."""

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    store: Store


def laid_out(case):
    """Balance and batteries of a case in one dimension."""
    balance = balance_of(case.time_h, case.solar_w, case.load_w)
    return balance, case.store.flat(case.solar_w.shape[:-1])


def final_energy_wh(balance, store, energy_wh):
    """Stored energy at the end of the time axis, marched over its surpluses alone."""
    return ChargingDay.of(balance).end_wh(store, energy_wh)


@st.composite
def cases(draw):
    """Any positive solar power and load on any axis, any battery, any batch shape."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    nodes = draw(st.integers(2, 30))
    gaps = rng.exponential(1.0, nodes - 1) + 1e-3
    time = np.concatenate(([0.0], np.cumsum(gaps) / gaps.sum() * 24.0))
    time[-1] = 24.0
    shape = draw(st.sampled_from([(), (1,), (3,), (2, 3)]))
    scale = 10.0 ** draw(st.floats(0.0, 4.0))
    solar = scale * np.maximum(rng.normal(0.3, 1.0, (*shape, nodes)), 0.0)
    load = scale * rng.uniform(0.0, draw(st.floats(0.01, 1.5)), (*shape, nodes))
    if draw(st.booleans()):
        load = np.broadcast_to(load[..., :1], load.shape)
    energy = scale * 10.0 ** rng.uniform(-2.0, 2.5, shape)
    battery = Battery(
        mass_kg=1.0,
        specific_energy_wh_per_kg=1.0,
        charge_efficiency=draw(st.floats(0.3, 1.0)),
        discharge_efficiency=draw(st.floats(0.3, 1.0)),
        charge_limit=draw(st.sampled_from(LIMITS)),
    )
    return Case(time, solar, load, Store.of(battery, energy))


@given(left=powers, right=powers, hours=st.floats(0.01, 5.0))
def test_positive_part_is_the_integral_of_the_positive_part(left, right, hours):
    found = float(positive_part_wh(np.asarray(left), np.asarray(right), hours))
    crossing = left / (left - right) if left * right < 0.0 else 0.5
    expected, _ = quad(
        lambda s: max(left + (right - left) * s, 0.0), 0.0, 1.0, points=[crossing], limit=100
    )
    # quad's own tolerance, 1.5e-8 relative, and as much of the interval's power.
    assert found == pytest.approx(expected * hours, rel=1e-7, abs=1e-8)


@given(left=st.floats(-500.0, -0.01), right=st.floats(0.01, 500.0))
def test_crossing_is_where_the_line_is_zero(left, right):
    s = float(crossing_fraction(np.asarray(left), np.asarray(right)))
    # Rounding.
    assert left + (right - left) * s == pytest.approx(0.0, abs=1e-9)


@given(left=st.floats(0.0, 500.0), right=st.floats(0.0, 500.0), share=st.floats(0.0, 1.0))
def test_ramp_fraction_is_where_the_share_is_reached(left, right, share):
    s = float(ramp_fraction(np.asarray(left), np.asarray(right), np.asarray(share)))
    reached = left * s + (right - left) * s * s / 2.0
    # The root's rounding is squared away; relative to the interval's whole.
    assert reached == pytest.approx(share * (left + right) / 2.0, abs=1e-9 * (1.0 + left + right))


def test_battery_that_empties_in_a_falling_power_is_found_by_hand():
    # Deficit of 100 t W over two hours, one that empties 50 Wh of a lossless battery: t = 1 h.
    balance = balance_of(np.array([0.0, 2.0]), np.array([0.0, 0.0]), np.array([0.0, 200.0]))
    store = Store.of(
        Battery(
            mass_kg=1.0,
            specific_energy_wh_per_kg=100.0,
            charge_efficiency=1.0,
            discharge_efficiency=1.0,
        )
    )
    (step,) = march(balance, store, np.array([50.0]))
    # Arithmetic by hand: rounding alone.
    assert step.empty_after_h() == pytest.approx(1.0, rel=1e-12)
    assert step.unserved_h() == pytest.approx(1.0, rel=1e-12)
    assert step.unserved_wh == pytest.approx(150.0, rel=1e-12)
    day = ChargingDay.of(balance)
    empty_at_wh, _, _ = day.flight(store, np.array([50.0]), np.zeros(1))
    assert day.hour_of_deficit(empty_at_wh, np.zeros(1, int)) == pytest.approx(1.0)


def test_time_must_increase_and_be_the_first_axis():
    with pytest.raises(ValueError, match="increase strictly"):
        PowerBalance.of(np.array([0.0, 1.0, 1.0]), np.zeros((3, 1)))
    with pytest.raises(ValueError, match="has length 4, not 3"):
        PowerBalance.of(np.array([0.0, 1.0, 2.0]), np.zeros((4, 3)))


@pytest.mark.parametrize("limit", LIMITS)
def test_a_thousand_random_cycles_conserve_energy_but_for_rounding(limit):
    rng = np.random.default_rng(9)
    time, shape = np.linspace(0.0, 24.0, 97), (1000, 97)
    solar = 100.0 * np.maximum(rng.normal(0.3, 1.0, shape), 0.0)
    load = 100.0 * rng.uniform(0.0, 1.0, (1000, 1)) * rng.uniform(0.5, 1.0, shape)
    energy = 10.0 ** rng.uniform(-1.0, 4.5, 1000)
    battery = Battery(mass_kg=1.0, specific_energy_wh_per_kg=1.0, charge_limit=limit)
    a = simulate_cycle(time, solar, load, Store.of(battery, energy)).energy_budget
    outgo = a.load_wh + a.stored_wh + a.charge_loss_wh + a.discharge_loss_wh + a.curtailed_wh
    # Rounding of sums over 96 intervals.
    wrong = np.abs(a.solar_wh + a.unserved_wh - outgo)
    assert np.max(wrong / (a.solar_wh + a.load_wh + energy)) < 1e-12


@settings(max_examples=80, deadline=None)
@given(case=cases())
def test_stored_energy_stays_within_the_battery(case):
    cycle = simulate_cycle(*case)
    full = case.store.battery_energy_wh[..., np.newaxis]
    assert np.all(cycle.energy_wh >= 0.0)
    # One rounding of a sum and a division.
    assert np.all(cycle.energy_wh <= full * (1.0 + 1e-12))
    assert np.all((cycle.minimum_state_of_charge >= 0.0) & (cycle.minimum_state_of_charge <= 1.0))
    # The hours of the day, summed from intervals: rounding.
    assert np.all((cycle.missing_h >= 0.0) & (cycle.missing_h <= 24.0 + 1e-9))
    assert np.all((cycle.charge_margin_h >= 0.0) & (cycle.charge_margin_h <= 24.0 + 1e-9))


@settings(max_examples=80, deadline=None)
@given(case=cases())
def test_metrics_are_those_of_the_cycle_marched_step_by_step(case):
    balance, store = laid_out(case)
    flat = (np.broadcast_to(w, case.solar_w.shape).reshape(-1, len(case.time_h)) for w in case[1:3])
    cycle = simulate_cycle(case.time_h, *flat, store)
    energy = cycle.energy_wh[..., 0]
    missing, unserved, nodes = 0.0, 0.0, [energy]
    for step in march(balance, store, energy):
        missing, unserved = missing + step.unserved_h(), unserved + step.unserved_wh
        nodes.append(step.end_wh)
    scale = store.battery_energy_wh + balance.deficit_wh.sum(axis=0)
    # As above; the fixed point is settled to 1e-11 of the capacity.
    trajectory = np.moveaxis(np.array(nodes), 0, -1)
    assert np.all(np.abs(trajectory - cycle.energy_wh) <= 1e-9 * scale[..., np.newaxis])
    assert np.all(np.abs(unserved - cycle.energy_budget.unserved_wh) <= 1e-9 * scale)
    # An hour's error is the energy's over the power at the instant of empty: near a crossing of
    # zero its square root.
    sure = np.asarray(unserved) > 1e-6 * scale
    np.testing.assert_allclose(
        np.asarray(missing)[sure], cycle.missing_h[sure], rtol=1e-6, atol=2e-3
    )


@settings(max_examples=50, deadline=None)
@given(case=cases())
def test_element_does_not_depend_on_the_batch_or_on_what_is_kept(case):
    batch = simulate_cycle(*case)
    light = simulate_cycle(*case, keep_trajectory=False)
    names = ("excess_time_h", "charge_margin_h", "full_charge_h", "missing_h", "status")
    for index in np.ndindex(case.solar_w.shape[:-1]):
        store = Store(
            np.asarray(case.store.battery_energy_wh[index]),
            case.store.charge_efficiency,
            case.store.discharge_efficiency,
            case.store.clock,
        )
        one = simulate_cycle(case.time_h, case.solar_w[index], case.load_w[index], store)
        for name in names:
            np.testing.assert_array_equal(getattr(batch, name)[index], getattr(one, name), name)
            np.testing.assert_array_equal(getattr(light, name)[index], getattr(one, name), name)
        np.testing.assert_array_equal(batch.energy_wh[index], one.energy_wh)


@settings(max_examples=50, deadline=None)
@given(case=cases())
def test_cycle_repeats_itself(case):
    balance, store = laid_out(case)
    energy = simulate_cycle(*case).energy_wh[..., 0].reshape(-1)
    again = final_energy_wh(balance, store, energy)
    # The search's own tolerance is far finer; rounding of 30 sums.
    assert np.all(np.abs(again - energy) <= 1e-9 * store.battery_energy_wh)
