import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from step_by_step import balance_of, march

from sizing.battery.battery import Battery, NoChargeLimit, RuleChargeLimit
from sizing.day.battery import Store
from sizing.day.march import ChargingDay
from sizing.day.record import (
    Dawns,
    carried_over,
    dawns_of,
    days_that_close,
    flight_hours,
    runs_empty,
)

TIME_H = np.linspace(0.0, 24.0, 49)


def store(energy_wh, days, *, taper=False):
    battery = Battery(
        mass_kg=energy_wh / 250.0,
        specific_energy_wh_per_kg=250.0,
        charge_efficiency=0.95,
        discharge_efficiency=0.97,
        charge_limit=RuleChargeLimit() if taper else NoChargeLimit(),
    )
    return Store.of(battery, np.full(days, float(energy_wh)))


def days_of(clearness, load_w=40.0, peak_w=200.0):
    """Power of days that differ in their light; each ends where the next begins."""
    bell = np.maximum(np.sin((TIME_H - 6.0) / 12.0 * np.pi), 0.0)
    solar = peak_w * np.asarray(clearness)[:, None] * bell
    return balance_of(TIME_H, solar, np.full(solar.shape, load_w))


def step_by_step(balance, its_store, start_wh):
    """Independent march: one interval after the other, day after day."""
    days = balance.net_w.shape[1]
    energy, nodes, unserved = float(start_wh), [], []
    for day in range(days):
        one = balance_of(balance.time_h, balance.net_w[:, day], 0.0)
        single = its_store.select(slice(day, day + 1))
        steps = list(march(one, single, np.array([energy])))
        nodes.append([energy, *(float(step.end_wh[0]) for step in steps)])
        unserved.append(sum(float(step.unserved_wh[0]) for step in steps))
        energy = nodes[-1][-1]
    return np.array(nodes), np.array(unserved)


def carried_from(balance, its_store, start_wh):
    return carried_over(ChargingDay.of(balance), its_store, start_wh)


def dawns(carried, noon_h=12.0):
    return dawns_of(carried.day, carried.store, noon_h)


def closing_days(balance, its_store, start_wh, noon_h):
    """Independent: dawns and days that close by steps of a minute, one after the other."""
    time_h = np.arange(0.0, 24.0, 1.0 / 60.0) + 1.0 / 120.0
    eta_in, eta_out = its_store.charge_efficiency, its_store.discharge_efficiency
    energy, begins, empty_at = float(start_wh), [], []
    for day in range(balance.net_w.shape[1]):
        net = np.interp(time_h, balance.time_h, balance.net_w[:, day])
        full = its_store.battery_energy_wh[day]
        charge, least, dawn = 0.0, 0.0, 0.0
        for hour, power in zip(time_h, net, strict=True):
            stored_wh = (power * eta_in if power > 0.0 else power / eta_out) / 60.0
            charge += stored_wh
            if charge < least and hour < noon_h:
                least, dawn = charge, hour + 1.0 / 120.0
            if energy + stored_wh < 0.0:
                empty_at.append(24.0 * day + hour)
            energy = min(max(energy + stored_wh, 0.0), full)
        begins.append(24.0 * day + dawn)
    ends = np.append(begins[1:], 24.0 * len(begins))
    at = np.array(empty_at)
    return np.array(begins), np.array(
        [not np.any((at > b + 0.02) & (at < e)) for b, e in zip(begins, ends, strict=True)]
    )


def test_blips_of_light_begin_no_day():
    net = np.where((TIME_H > 7.0) & (TIME_H < 17.0), 60.0, -40.0)[:, None] * np.ones(3)
    net[10:12, 1] = 5.0  # a blip at five
    net[:, 2] = -40.0
    net[30:32, 2] = 5.0  # and one in the afternoon of a dark day
    balance = balance_of(TIME_H, net.T, 0.0)
    found = dawns(carried_from(balance, store(500.0, 3), 500.0))
    # From -40 to 60 W between 7.0 and 7.5; the dark day has its least charge at noon.
    assert found.hour == pytest.approx([7.2, 7.2, 12.0])
    assert found.deficit_wh[1] < found.deficit_wh[0]  # the blip's surplus is no deficit
    assert found.deficit_wh[2] == pytest.approx(480.0)


def test_days_that_close_are_those_of_a_plain_loop():
    random = np.random.default_rng(3)
    days, noon_h = 60, 11.5
    # Broken clouds that change from half-hour to half-hour, on bright and on dim days.
    share = random.uniform(0.2, 1.5, days)[:, None] * random.uniform(0.0, 1.6, (days, 49))
    bell = np.maximum(np.sin((TIME_H - 6.0) / 12.0 * np.pi), 0.0)
    balance = balance_of(TIME_H, 220.0 * share * bell, 40.0)
    for energy in (620.0, 700.0, 1100.0):
        its_store = store(energy, days)
        carried = carried_from(balance, its_store, energy)
        found = dawns(carried, noon_h)
        begins, closes = closing_days(balance, its_store, energy, noon_h)
        assert 24.0 * np.arange(days) + found.hour == pytest.approx(begins, abs=0.05)
        assert days_that_close(carried, found).tolist() == closes.tolist()
        assert 0 < closes.sum() < days


clearness_of_days = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=9)


@settings(max_examples=40)
@given(
    clearness=clearness_of_days,
    energy=st.floats(100.0, 4000.0),
    begin=st.floats(0.0, 1.0),
    taper=st.booleans(),
)
def test_all_days_at_once_are_the_days_one_after_the_other(clearness, energy, begin, taper):
    balance = days_of(clearness)
    its_store = store(energy, len(clearness), taper=taper)
    run = carried_from(balance, its_store, begin * energy)
    nodes, unserved = step_by_step(balance, its_store, begin * energy)
    # The same arithmetic in another order.
    assert pytest.approx(nodes, rel=1e-9, abs=1e-9 * energy) == run.energy_at_nodes_wh().T
    empty = np.logical_or(*runs_empty(run, dawns(run)))
    clear = (unserved > 1e-6) | (unserved < 1e-12)
    assert np.array_equal(empty[clear], unserved[clear] > 1e-6)


def test_a_battery_that_is_empty_for_a_moment_between_two_nodes_is_empty():
    balance = days_of([1.0, 1.0])
    solar = balance.net_w[:, 0] > 0.0
    night_wh = balance.deficit_wh[:, 0].sum() / 0.97  # of an evening and the morning after it
    for share, empty in ((0.9999, True), (1.0001, False)):
        its_store = store(share * night_wh, 2)
        carried = carried_from(balance, its_store, its_store.battery_energy_wh[0])
        before, after = runs_empty(carried, dawns(carried))
        assert carried.energy_at_nodes_wh()[np.argmax(solar) :].min() > 0.0
        assert before.tolist() == [False, empty]
        assert not after.any()


@settings(max_examples=30)
@given(clearness=clearness_of_days, energy=st.floats(200.0, 3000.0), launch=st.floats(5.0, 9.0))
def test_flights_end_when_a_battery_marched_alone_is_empty(clearness, energy, launch):
    days = len(clearness)
    balance, its_store = days_of(clearness), store(energy, days)
    launches = np.full(days, np.round(launch * 2.0) / 2.0)  # on a node, for the march alone
    run = carried_from(balance, its_store, energy)
    hours = flight_hours(run.day, its_store, run, launches)
    first = int(launches[0] * 2.0)
    for begin in range(days):
        left, flown = energy, None
        for day in range(begin, days):
            skip = first if day == begin else 0
            part = balance_of(TIME_H[skip:], balance.net_w[skip:, day], 0.0)
            for step in march(part, its_store.select(slice(0, 1)), np.array([left])):
                left = float(step.end_wh[0])
                if float(step.unserved_wh[0]) > 1e-9 * energy:
                    flown = (day - begin) * 24.0 + float(step.interval.start_h[0]) - launches[0]
                    break
            if flown is not None:
                break
        assert np.isinf(hours[begin]) == (flown is None)
        if flown is not None:
            assert flown - 1e-6 <= hours[begin] <= flown + 0.5 + 1e-6  # within that interval


def test_a_battery_that_is_empty_at_midnight_was_so_before_a_later_dawn_alone():
    balance = days_of([0.3])
    its_store = store(400.0, 1)
    carried = carried_from(balance, its_store, its_store.battery_energy_wh[0])
    # What midnight lacks was not delivered: so much less than the whole deficit of the day.
    emptied_wh = balance.deficit_wh.sum() + 0.97 * carried.midnight_wh[0]
    assert carried.midnight_wh[0] < -100.0
    for beside_wh, empty in ((-1.0, False), (1.0, True)):
        dawn = Dawns(np.array([20.0]), np.array([emptied_wh + beside_wh]))
        before, after = runs_empty(carried, dawn)
        assert before.tolist() == [empty]
        assert after.tolist() == [True]
