"""The day of a program: its intervals return the energy of the day that they are cut from."""

from dataclasses import replace

import numpy as np
import pytest
from builders import DESIGN, UNLIMITED_AS2, mission

from sizing.day.battery import Store
from sizing.day.light import DEFAULT_STEP_H, solar_day
from sizing.design import variables_of
from sizing.performance import performance_of_designs
from sizing.program.intervals import (
    CutDay,
    Day,
    DayMeans,
    held_back,
    light_at_heights,
    mean_light_w,
)
from sizing.program.transcription import LEVELS, Form, lagrange

INTO, OUT_OF = 0.95, 0.9
FORMS = [Form(1), Form(1, climbs=True)]


def day_of(step_h=DEFAULT_STEP_H, **changes):
    """Return the repeated day of a design, and its nominal load [W]."""
    flight = mission(**changes)
    light = solar_day(DESIGN, flight, step_h=step_h)
    perf = performance_of_designs(DESIGN, flight, variables_of(DESIGN), day=light)
    powers = np.atleast_2d(perf.solar_power_w), np.atleast_2d(perf.load_w)
    return Day.of(light.time_h, *powers), float(np.ravel(perf.nominal_load_w)[0])


def cut(day, nominal_w, form):
    """Cut a day on which nothing is known of the charge."""
    path = np.linspace(0.5, 0.9, len(day.time_h))
    store = replace(
        Store.of(DESIGN.battery, np.array([700.0])),
        charge_efficiency=INTO,
        discharge_efficiency=OUT_OF,
    )
    return CutDay.of(day, path, store, nominal_w, form, np.zeros(len(path)))


def energy_wh(day, power_w):
    """Return the energy of a power that is straight between times, by a fine sum."""
    fine_h = np.linspace(day.time_h[0], day.time_h[-1], 200_001)
    return float(np.interp(fine_h, day.time_h, power_w)[:-1].mean() * np.ptp(fine_h))


@pytest.mark.parametrize("date", ["01-15", "06-21"])
def test_a_day_begins_at_sunrise_and_loses_no_light(date):
    day, _ = day_of(dates={"on": date})
    light = solar_day(DESIGN, mission(dates={"on": date}))
    midnight_w = light.specific_power_w_per_m2[0] * float(DESIGN.modules.area_m2)
    assert day.solar_w[0, 0] == day.solar_w[0, -1] == 0.0
    assert day.solar_w[0, 1] > 0.0
    assert np.ptp(day.time_h) == pytest.approx(24.0)
    assert np.trapezoid(day.solar_w[0], day.time_h) == pytest.approx(
        np.trapezoid(midnight_w, light.time_h), rel=1e-12
    )


@pytest.mark.parametrize(("least_w", "begin_h"), [(1.0, 0.0), (-1.0, 6.0)])
@pytest.mark.parametrize("clock_h", [0.0, 5.0, 12.0])
def test_a_day_begins_at_sunrise_or_where_the_sun_is_lowest_by_any_clock(least_w, begin_h, clock_h):
    time_h = np.linspace(0.0, 24.0, 49)
    sun_w = np.maximum(least_w + 1.0 - np.cos((time_h - clock_h) * np.pi / 12.0), 0.0).round(9)
    day = Day.of(time_h, sun_w[np.newaxis], np.ones((1, 49)))
    assert day.time_h[[0, -1]] == pytest.approx((begin_h + clock_h) % 24.0 + np.array([0.0, 24.0]))
    assert day.solar_w[0, 0] == sun_w.min()


@pytest.mark.parametrize("form", FORMS)
def test_nodes_of_few_steps_are_all_different(form):
    day, nominal_w = day_of(step_h=0.5)
    assert np.all(np.diff(cut(day, nominal_w, form).nodes) > 0)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("date", ["01-15", "06-21"])
def test_nodes_lie_where_light_and_surplus_begin_and_end(date, form):
    day, nominal_w = day_of(dates={"on": date})
    intervals, steps = cut(day, nominal_w, form), len(day.time_h) - 1
    nodes = intervals.nodes
    assert len(nodes) == form.intervals + 1
    assert nodes[0] == 0
    assert nodes[-1] == steps
    assert np.all(np.diff(nodes) > 0)
    solar_w, net_w = day.solar_w[0], day.solar_w[0] - day.load_w[0]
    sunset = int(np.flatnonzero(solar_w > 0.0)[-1]) + 1
    assert sunset in nodes
    turns = np.flatnonzero(np.diff(np.sign(net_w)))
    assert len(turns) == 2
    for turn in turns:  # at the end of the step where less is left over or lacks
        assert turn + int(np.argmin(np.abs(net_w[turn : turn + 2]))) in nodes
    # Half the intervals at least are of light, in which powers change.
    assert np.count_nonzero(nodes < sunset) > form.intervals // 2
    # The excess time must be left until the sun carries the load, not after the forenoon.
    reserve = nodes[intervals.reserve]
    assert solar_w[reserve[-1]] >= nominal_w > solar_w[reserve[-2] - 1]
    assert solar_w[reserve[-1]] < 0.9 * solar_w.max()


@pytest.mark.parametrize("form", FORMS)
def test_intervals_hold_light_and_storage_of_their_day(form):
    day, nominal_w = day_of()
    means = cut(day, nominal_w, form).means
    assert means.hours.sum() == pytest.approx(24.0)
    light_wh = float(means.light_w[0] @ means.hours)
    assert light_wh == pytest.approx(energy_wh(day, day.solar_w[0]), rel=1e-6)
    net_w = means.light_w[0] - means.load_w[0]
    stored_wh = float(np.minimum(INTO * net_w, net_w / OUT_OF) @ means.hours)
    net = Day(day.time_h, day.solar_w - day.load_w, day.load_w, 0)
    fine_h = np.linspace(net.time_h[0], net.time_h[-1], 200_001)
    fine_w = np.interp(fine_h, net.time_h, net.solar_w[0])
    charged_w = np.minimum(INTO * fine_w, fine_w / OUT_OF)
    assert stored_wh == pytest.approx(float(charged_w[:-1].mean()) * 24.0, rel=1e-6)


def test_light_of_all_heights_is_that_of_the_flight_at_its_heights():
    day, nominal_w = day_of()
    form = Form(1, climbs=True)
    nodes = cut(day, nominal_w, form).nodes
    share = np.interp(day.time_h[nodes] % 24.0, [6.0, 12.0, 20.0], [0.0, 0.9, 0.1])
    # Half a per cent more light with every level.
    factors = 1.0 + 0.005 * np.arange(LEVELS)
    rows = factors[:, np.newaxis] * day.solar_w
    levels = Day(day.time_h, rows, np.zeros_like(rows), day.first)
    flight_w = 1.01 * mean_light_w(day, nodes)[0]
    known = light_at_heights(levels, nodes, share, flight_w)
    weights = np.stack(lagrange((share[1:] + share[:-1]) / 2.0, LEVELS))
    assert np.sum(weights * known, axis=0) == pytest.approx(flight_w, rel=1e-12)
    bright = flight_w > 0.0
    ratios = known[:, bright] / known[0, bright]
    assert ratios == pytest.approx(np.repeat(factors[:, np.newaxis], bright.sum(), 1), rel=1e-12)


@pytest.mark.parametrize("plane", [DESIGN, UNLIMITED_AS2])
def test_what_a_battery_holds_back_makes_equations_of_the_rows(plane):
    rng, full_wh, hours = np.random.default_rng(3), 700.0, np.full(300, 0.5)
    store = Store.of(plane.battery, np.array([full_wh]))
    into, out_of = float(store.charge_efficiency), float(store.discharge_efficiency)

    def least_gain(net_w, soc, limit_h, highest):
        """Return what the least of power, charge limit and capacity charges."""
        power = np.where(net_w > 0.0, into * net_w, net_w / out_of) * hours[0] / full_wh
        limited = store.clock.after(soc, limit_h) - soc
        return np.minimum(np.minimum(power, limited), highest - soc)

    net_w, soc = rng.choice([-300.0, -0.5, 0.5, 60.0, 600.0], len(hours)), [0.5]
    for power_w in net_w:
        gain = float(least_gain(power_w, soc[-1], hours[0], 1.0))
        # Now and then a flight charges less than any of them allows.
        gain *= rng.choice([1.0, 0.7]) if gain > 0.0 else 1.0
        soc.append(max(soc[-1] + gain, 0.1))
    charge = np.array(soc)
    means = DayMeans(hours, np.maximum(net_w, 0.0)[np.newaxis], np.maximum(-net_w, 0.0)[np.newaxis])
    held = held_back(store, charge, means)
    left_w = net_w - held.turned_away_w
    gains = least_gain(left_w, charge[:-1], held.limit_h, held.most[1:])
    inside = charge[1:] > 0.1
    assert gains[inside] == pytest.approx(np.diff(charge)[inside], abs=1e-8)
    assert np.any(held.most < 1.0)
    for of_a_limit in (held.limit_h < hours, held.turned_away_w > 0.0):
        assert np.any(of_a_limit) == (plane is DESIGN)
