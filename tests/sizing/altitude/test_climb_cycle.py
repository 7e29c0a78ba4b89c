"""Potential-energy storage: against plain marching, arithmetic by hand, limits and invariants."""

from __future__ import annotations

from functools import cache
from typing import Any

import ambiance
import builders
import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR, UNLIMITED_AS2
from hypothesis import example, given, settings
from hypothesis import strategies as st
from plain_climb import ETA, FLOOR_M, PlainClimb

from missions.air import standard_air
from missions.dates import date_code
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.altitude.climb_cycle import ClimbPerformance, climb_performance
from sizing.altitude.climb_levels import ClimbLimitError, checked_climb_limits
from sizing.energy.cycle import Status
from sizing.mass_budget import design_of
from sizing.performance import performance
from sizing.sunlight import SolarModel

pytestmark = pytest.mark.slow


def mission(ceiling_m: float, strategy: str = "battery_full", **changes: Any) -> Mission:
    climb = {"ceiling_m": ceiling_m, "strategy": strategy}
    return builders.mission(**{"dates": {"on": "06-21"}, "climb": climb} | changes)


SOLSTICES = "06-21", "12-21"  # five days between them, 21 September and 5 November included


@cache
def flown(
    aircraft: Aircraft,
    ceiling_m: float,
    strategy: str = "battery_full",
    dates: str | tuple[str, str] = "06-21",
) -> ClimbPerformance:
    first, last = (dates, None) if isinstance(dates, str) else dates
    days = {"from": first, "to": last, "count": 5} if last else {"on": first}
    return climb_performance(aircraft, mission(ceiling_m, strategy, dates=days))


# ---- Without height it is the simulator of constant altitude


@pytest.mark.parametrize(
    ("aircraft", "dates"),
    [(AS2, SOLSTICES), (AS2, "10-10"), (UNLIMITED_AS2, SOLSTICES), (DESIGN, SOLSTICES)],
)
@pytest.mark.parametrize("strategy", ["battery_full", "surplus"])
def test_ceiling_at_the_floor_is_the_constant_altitude_simulator(
    aircraft: Aircraft, dates: str | tuple[str, str], strategy: str
) -> None:
    result = flown(aircraft, FLOOR_M, strategy, dates)
    ours, theirs = result.performance.cycle, result.constant.cycle
    np.testing.assert_array_equal(ours.status, theirs.status)
    # Steps of 1 against 5 min: only the switch between charger's and sun's limit depends on them.
    assert ours.excess_time_h == pytest.approx(theirs.excess_time_h, abs=1e-3)
    assert ours.minimum_state_of_charge == pytest.approx(theirs.minimum_state_of_charge, abs=1e-4)
    assert ours.charge_margin_h == pytest.approx(theirs.charge_margin_h, abs=0.05)  # 2 x 1 min
    assert ours.missing_h == pytest.approx(theirs.missing_h, abs=5e-3)
    assert ours.energy_wh == pytest.approx(theirs.energy_wh, abs=1e-3 * 732.0)
    for name in ("solar_wh", "load_wh"):
        expected = getattr(theirs.energy_budget, name)
        assert getattr(ours.energy_budget, name) == pytest.approx(expected, rel=1e-9)
    assert np.all(result.climb.maximum_altitude_m == FLOOR_M)
    assert np.all(result.climb.gliding_h == 0.0)
    assert np.all(result.gain_h == pytest.approx(0.0, abs=1e-3))


def test_thermals_and_payload_reduce_to_the_constant_altitude_simulator() -> None:
    result = climb_performance(
        DESIGN,
        mission(
            FLOOR_M,
            turbulence={"all_day": 0.1, "thermal": 0.4},
            payload={"mass_kg": 0.2, "power_w": 3.0},
        ),
    )
    ours, theirs = result.performance.cycle, result.constant.cycle
    # The two march with other steps: 4 s.
    assert ours.excess_time_h == pytest.approx(theirs.excess_time_h, abs=1e-3)
    assert ours.energy_budget.load_wh == pytest.approx(theirs.energy_budget.load_wh, rel=1e-9)
    # The load of every step, with thermals that come and go, is that of its middle there.
    middles = (result.climb.time_h[1:] + result.climb.time_h[:-1]) / 2.0
    day = result.constant
    expected = np.interp(middles, day.cycle.time_h, np.ravel(day.load_w))
    assert np.ptp(expected) > 0.2 * expected.min()
    assert result.climb.load_w[0, :-1] == pytest.approx(expected, rel=1e-9)


# ---- The energy budget


@settings(max_examples=3, deadline=None)  # a second and seven days of the year each
@example(5629.0, {"on": "10-10"}, "battery_full", AS2, 0.125)  # gains that do not shrink
@given(
    ceiling_m=st.floats(FLOOR_M, 15000.0),
    days=st.just({"from": "12-21", "to": "10-10", "count": 7}),
    strategy=st.sampled_from(["battery_full", "surplus"]),
    aircraft=st.sampled_from([AS2, UNLIMITED_AS2, DESIGN]),
    thermal=st.floats(0.0, 1.0),
)
def test_energy_is_neither_made_nor_lost(
    ceiling_m: float, days: dict[str, Any], strategy: str, aircraft: Aircraft, thermal: float
) -> None:
    where = mission(ceiling_m, strategy, dates=days, turbulence={"thermal": thermal})
    result = climb_performance(aircraft, where)
    climb, budget = result.climb, result.climb.energy_budget
    sources = budget.solar_wh + budget.unserved_wh
    uses = budget.constant_load_wh + budget.level_flight_wh + budget.propulsion_loss_wh
    uses = uses + budget.stored_wh + budget.stored_potential_wh + budget.curtailed_wh
    uses = uses + budget.charge_loss_wh + budget.discharge_loss_wh
    assert np.all(np.abs(sources - uses) <= 1e-9 * budget.solar_wh)
    # What the trajectories tell, against what the flows add up to.
    assert budget.stored_wh == pytest.approx(climb.energy_wh[:, -1] - climb.energy_wh[:, 0])
    eta = result.limits.efficiency
    assert budget.stored_potential_wh == pytest.approx(
        eta * budget.climb_electric_wh - budget.glide_potential_wh, abs=1e-9 * 732.0
    )
    # The day repeats itself.
    capacity = float(result.performance.design.battery_energy_wh)
    assert np.all(np.abs(budget.stored_wh) <= 1e-6 * capacity)
    assert np.all(np.abs(budget.stored_potential_wh) <= 1e-6 * capacity)
    # Bounds of every flight.
    assert np.all(climb.energy_wh >= 0.0)
    assert np.all(climb.energy_wh <= capacity * (1.0 + 1e-12))
    assert np.all(climb.altitude_m >= FLOOR_M - 1e-9)
    assert np.all(climb.altitude_m <= ceiling_m + 1e-6)
    for name in ("charge_loss_wh", "discharge_loss_wh", "propulsion_loss_wh", "curtailed_wh"):
        assert np.all(getattr(budget, name) >= -1e-9)


def test_energy_budget_that_other_tables_show_closes_too() -> None:
    budget = flown(AS2, 3536.0).performance.cycle.energy_budget
    sources = budget.solar_wh + budget.unserved_wh
    uses = budget.load_wh + budget.stored_wh + budget.charge_loss_wh
    assert sources == pytest.approx(uses + budget.discharge_loss_wh + budget.curtailed_wh, rel=1e-9)


# ---- By hand


def test_potential_energy_of_a_kilometre_is_m_g_h() -> None:
    # 6.92 kg x 9.81 m/s2 x 1000 m = 68 kJ = 18.9 Wh; the kinetic energy of flying faster in thinner
    # air (8.2 to 8.6 m/s) adds 0.05 %.
    stored = flown(AS2, FLOOR_M + 1000.0).climb.maximum_potential_energy_wh[0]
    assert stored == pytest.approx(6.92 * 9.80665 * 1000.0 / 3600.0, rel=1e-3)
    assert stored == pytest.approx(18.9, abs=0.05)


@pytest.mark.parametrize("rise_m", [1000.0, 3000.0])
def test_gain_is_what_the_height_saves_the_battery(rise_m: float) -> None:
    result = flown(AS2, FLOOR_M + rise_m)
    height_wh = float(result.climb.maximum_potential_energy_wh[0])
    nominal_w = float(result.constant.nominal_load_w[0])
    # Height replaces motor power, W / eta of the electric kind, but sinks faster where it is high:
    # between the power at the ceiling and that at the floor. The light aloft, which the evening
    # has more of, may add some per cent.
    density = ambiance.Atmosphere(np.array([FLOOR_M, FLOOR_M + rise_m])).density
    at_best = height_wh / ETA / nominal_w
    at_worst = at_best * (density[1] / density[0]) ** 0.5
    assert at_worst <= result.gain_h[0] <= 1.05 * at_best


def test_glide_takes_as_long_as_the_sink_rate_says() -> None:
    from scipy.integrate import quad

    # In the dark with the motor off: dh/dt = eta P_level / (m g), density by ambiance.
    late = flown(UNLIMITED_AS2, 9000.0).climb
    dark = (late.solar_power_w[0] == 0.0) & (np.arange(len(late.time_h)) > 720)
    sinking = dark & (late.altitude_m[0] > FLOOR_M + 30.0)
    top, bottom = late.altitude_m[0][sinking][[0, -1]]
    hours = late.time_h[sinking][-1] - late.time_h[sinking][0]

    def slowness(height_m: float) -> float:
        density = float(ambiance.Atmosphere(height_m).density[0])
        power_w = 35.8 * (density / 1.10) ** -0.5 * ETA
        return 6.92 * 9.80665 / power_w

    expected = quad(slowness, bottom, top)[0] / 3600.0
    # The kinetic energy given back makes the glide 0.06 % longer; tables every 500 m.
    assert hours == pytest.approx(expected, rel=2e-3)
    assert hours > 0.5


def test_zephyr_like_aircraft_needs_hours_from_18_to_12_km() -> None:
    # Zephyr 7: 53 kg and 22.5 m, 18 km by day and 12 km at night. Its power is not published; the
    # lift-to-drag ratio of 30 at 1.0 of lift on 27.9 m2 is an assumption of this test.
    weight, area = 53.0 * 9.80665, 27.9
    density = float(ambiance.Atmosphere(12000.0).density[0])
    speed = np.sqrt(2.0 * weight / (density * area))
    level_w = weight / 30.0 * speed / 0.65
    data = AS2.model_dump(by_alias=True)
    data["airframe"] |= {"wingspan_m": 22.5, "aspect_ratio": 22.5**2 / area}
    data["airframe"] |= {"mass_without_battery_kg": 37.0}
    data["airframe"]["level_flight"] = {
        "electric_power_w": float(level_w),
        "mass_kg": 53.0,
        "density_kg_per_m3": density,
        "airspeed_m_per_s": float(speed),
        "maximum_electric_power_w": 1500.0,
        "propulsion_efficiency": 0.65,
    }
    data["modules"] |= {"area_m2": 20.0, "geometry": None, "tail": None}
    data["battery"] = {"mass_kg": 16.0, "specific_energy_wh_per_kg": 350.0}
    data["power"]["avionics_w"] = 50.0
    zephyr = Aircraft.model_validate(data)
    where = mission(
        18000.0, "surplus", altitude_m=12000.0, latitude_deg=32.0, dates={"on": "07-15"}
    )
    result = climb_performance(zephyr, where)
    climb = result.climb
    # It reaches the published day altitude and spends the night at the published one.
    assert climb.maximum_altitude_m[0] == pytest.approx(18000.0, abs=1.0)
    assert climb.altitude_m[0][0] == pytest.approx(12000.0, abs=1.0)
    # m g 6 km = 866 Wh, and 0.3 to 1 % for the speed that doubles the dynamic of thin air.
    potential = 53.0 * 9.80665 * 6000.0 / 3600.0
    assert potential < climb.maximum_potential_energy_wh[0] < 1.015 * potential
    # Sinking 6 km at L/D 30 and 15 to 25 m/s: 0.5 to 0.85 m/s without sun, 2 to 3.4 h; the evening
    # sun still carries a part, so that it takes longer.
    assert 2.0 < climb.gliding_h[0] < 6.0
    assert result.gain_h[0] > 0.0


# ---- Against plain marching, second by second


def plain_day(ceiling_m: float, energy: float, altitude: float) -> tuple[float, float, float]:
    """March AS-2 without charge limit: energy after a day, highest altitude, energy at dawn."""
    plain = PlainClimb(172, ceiling_m)
    state, highest, dawn = (np.array([energy]), np.array([altitude])), altitude, -1.0
    for k in range(round(24.0 / plain.step_h)):
        hour = k * plain.step_h
        *after, net = plain.step(np.array([hour]), *state)
        if dawn < 0.0 and hour > 2.0 and net[0] >= 0.0:
            dawn = float(state[0][0])
        state = after[0], after[1]
        highest = max(highest, float(state[1][0]))
    return float(state[0][0]), highest, dawn


@pytest.mark.parametrize("ceiling_m", [1536.0, 3536.0, 9000.0])
def test_cycle_agrees_with_plain_marching(ceiling_m: float) -> None:
    as_cold = {"module_temperature_c": float(standard_air(FLOOR_M).temperature_c)}
    result = climb_performance(UNLIMITED_AS2, mission(ceiling_m, air=as_cold))
    start = float(result.climb.energy_wh[0, 0])
    altitude = float(result.climb.altitude_m[0, 0])
    energy, highest, dawn = plain_day(ceiling_m, start, altitude)
    # Euler with 10 s errs by some 0.1 Wh in the evening's glide, which ends within one step.
    assert energy == pytest.approx(start, abs=0.5)
    assert highest == pytest.approx(float(result.climb.maximum_altitude_m[0]), abs=5.0)
    excess = dawn * 0.97 / float(result.constant.nominal_load_w[0])
    assert result.performance.cycle.excess_time_h[0] == pytest.approx(excess, abs=0.02)


def test_finer_steps_of_the_day_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from sizing.altitude import climb_march

    coarse = flown(AS2, 3536.0)
    monkeypatch.setattr(climb_march, "STEPS_PER_NODE", 25)
    fine = climb_performance(AS2, mission(3536.0))
    # Three digits, as everywhere; 1 min against 12 s.
    assert coarse.performance.cycle.excess_time_h[0] == pytest.approx(
        fine.performance.cycle.excess_time_h[0], rel=1e-3
    )
    assert coarse.climb.gliding_h[0] == pytest.approx(fine.climb.gliding_h[0], abs=0.04)


def test_finer_levels_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from missions import mission as missions_mission

    coarse = flown(AS2, 6536.0).performance.cycle.excess_time_h[0]
    monkeypatch.setattr(missions_mission, "LEVEL_SPACING_M", 50.0)
    monkeypatch.setattr(missions_mission, "MAXIMUM_LEVELS", 500)
    fine = climb_performance(AS2, mission(6536.0)).performance.cycle.excess_time_h[0]
    # Three digits, as everywhere; 500 m against 50 m.
    assert coarse == pytest.approx(fine, rel=1e-3)


# ---- Invariants


@pytest.mark.parametrize(
    ("aircraft", "dates"), [(AS2, SOLSTICES), (AS2, "10-10"), (DESIGN, SOLSTICES)]
)
def test_climbing_with_a_full_battery_never_harms(
    aircraft: Aircraft, dates: str | tuple[str, str]
) -> None:
    gains = [flown(aircraft, h, dates=dates).gain_h for h in (FLOOR_M, 1536.0, 4000.0)]
    assert gains[0] == pytest.approx(0.0, abs=1e-3)
    assert np.all(gains[1] >= gains[0] - 1e-3)  # the step's accuracy
    assert np.all(gains[2] >= gains[1] - 1e-3)


def test_climbing_carries_a_small_battery_through_the_night() -> None:
    small = builders.aircraft("atlantiksolar-as2", "battery.specific_energy_wh_per_kg=130")
    result = flown(small, 5000.0)
    ours, theirs = result.performance.cycle, result.constant.cycle
    assert theirs.status[0] == Status.limited
    assert ours.status[0] == Status.perpetual
    assert theirs.excess_time_h[0] < 0.0 < ours.excess_time_h[0]
    assert ours.minimum_state_of_charge[0] > 0.0
    assert ours.missing_h[0] == pytest.approx(0.0, abs=1e-12)  # rounding


def test_battery_that_is_never_full_leaves_nothing_to_climb_with() -> None:
    result = flown(AS2, 4000.0, dates="12-21")
    assert result.climb.maximum_altitude_m[0] == FLOOR_M
    assert result.performance.cycle.status[0] == Status.limited


def test_climb_keeps_to_the_rated_power_and_the_sun() -> None:
    climb = flown(AS2, 6536.0).climb
    assert np.all(climb.load_w <= 180.0 + 6.0 + 1e-6)
    climbing = np.diff(climb.altitude_m[0]) > 0.1
    # The battery never pays for height.
    assert np.all(np.diff(climb.energy_wh[0])[climbing] >= -1e-9)
    # Largest rate of climb: eta (180 W - level) / (m g).
    rate = np.diff(climb.altitude_m[0]).max() / 60.0
    assert rate < ETA * (180.0 - 34.8) / (6.92 * 9.80665)
    assert rate > 0.9 * ETA * (180.0 - 44.0) / (6.92 * 9.80665)


def test_height_is_used_before_the_battery() -> None:
    climb = flown(AS2, 3536.0).climb
    above = climb.altitude_m[0][:-1] > FLOOR_M + 50.0
    drain_w = -np.diff(climb.energy_wh[0]) * 60.0
    # Aloft the battery gives at most what avionics draw: 6 W.
    assert drain_w[above].max() <= 6.0 / 0.97 + 1e-6
    assert drain_w[~above].max() > 35.0


def test_strategies_agree_where_charging_is_not_limited() -> None:
    # The charger takes everything until the battery is full: nothing is left over before.
    first = flown(UNLIMITED_AS2, 3536.0, "battery_full").performance.cycle.excess_time_h[0]
    second = flown(UNLIMITED_AS2, 3536.0, "surplus").performance.cycle.excess_time_h[0]
    assert first == pytest.approx(second, abs=1e-6)


def test_surplus_strategy_climbs_earlier() -> None:
    early, late = (
        int(np.argmax(flown(AS2, 3536.0, strategy).climb.altitude_m[0] > FLOOR_M + 1.0))
        for strategy in ("surplus", "battery_full")
    )
    assert early < late


def test_model_error_moves_the_result_the_right_way() -> None:
    low, high = (
        climb_performance(AS2, mission(3000.0), solar_factor=factor) for factor in (0.9, 1.1)
    )
    assert low.performance.cycle.excess_time_h[0] < high.performance.cycle.excess_time_h[0]


def test_scenarios_do_not_disturb_each_other() -> None:
    days = {"from": "05-01", "to": "09-01", "count": 3}
    together = climb_performance(AS2, mission(3536.0, dates=days))
    for place, day in enumerate(together.performance.day.scenarios.day_of_year):
        alone = flown(AS2, 3536.0, dates=date_code(int(day)))
        assert together.performance.cycle.excess_time_h[place] == pytest.approx(
            alone.performance.cycle.excess_time_h[0], abs=1e-6
        )


def test_polar_day_has_no_end() -> None:
    where = mission(2000.0, latitude_deg=85.0, dates={"on": "06-21"})
    result = climb_performance(AS2, where)
    assert result.performance.cycle.status[0] == Status.always_lit
    assert np.isinf(result.performance.cycle.excess_time_h[0])
    assert result.gain_h[0] == 0.0


def test_height_left_at_dawn_counts_for_the_excess_time() -> None:
    # A short night and a high ceiling: the aircraft still glides when the sun takes over.
    where = mission(20000.0, "surplus", latitude_deg=66.0, dates={"on": "05-20"})
    result = climb_performance(UNLIMITED_AS2, where)
    climb, cycle = result.climb, result.performance.cycle
    dawn = cycle.equal_power_morning_h[0]
    height_m = float(np.interp(dawn, climb.time_h, climb.altitude_m[0]))
    energy = float(np.interp(dawn, climb.time_h, climb.energy_wh[0]))
    nominal = float(result.constant.nominal_load_w[0])
    on_battery = energy * 0.97 / nominal
    if height_m < FLOOR_M + 1.0:
        pytest.fail("the case is meant to leave height at dawn")
    assert cycle.excess_time_h[0] > on_battery
    # At most what the height is worth at the floor's sink rate.
    mass_n = 6.92 * 9.80665
    at_floor = mass_n * (height_m - FLOOR_M) / 3600.0 / (ETA * (nominal - 6.0))
    assert cycle.excess_time_h[0] < on_battery + 1.02 * at_floor


@pytest.mark.parametrize("model", ["CDM", "VM", "FM"])
def test_every_solar_model_can_be_climbed_with(model: Any) -> None:
    path = {"kind": "circle", "radius_m": 100.0, "airspeed_m_per_s": 8.6}
    result = climb_performance(AS2, mission(2000.0, flight_path=path), SolarModel(model))
    assert result.gain_h[0] > 0.5


# ---- Refusals


def test_mission_without_climb_is_refused() -> None:
    plain = mission(1536.0).at_altitude(FLOOR_M)
    with pytest.raises(ValueError, match="has no climb"):
        climb_performance(AS2, plain)


@pytest.mark.parametrize(
    ("aircraft", "key"),
    [
        *(
            (builders.aircraft("atlantiksolar-as2", f"{key}=null"), key)
            for key in (
                "airframe.level_flight.maximum_electric_power_w",
                "airframe.level_flight.propulsion_efficiency",
            )
        ),
        (SKY_SAILOR, "airframe.propulsion.climb_power_ratio"),
    ],
)
def test_aircraft_that_cannot_climb_is_refused(aircraft: Aircraft, key: str) -> None:
    with pytest.raises(ClimbLimitError, match=key):
        climb_performance(aircraft, mission(2000.0))


def test_rated_power_of_a_parametric_aircraft_is_its_ratio_to_level_flight() -> None:
    design = design_of(DESIGN, mission(2000.0))
    limits = checked_climb_limits(DESIGN, design)
    assert limits.maximum_power_w == pytest.approx(5.03 * float(design.propulsion_power_w))
    assert limits.efficiency == pytest.approx(0.97 * 0.82 * 0.96 * 0.82)


def test_performance_of_a_constant_altitude_ignores_nothing() -> None:
    # The constant flight beside the climbing one is what analyse says without climb.
    alone = performance(AS2, mission(1536.0).at_altitude(FLOOR_M)).cycle.excess_time_h
    assert flown(AS2, 1536.0).constant.cycle.excess_time_h == pytest.approx(alone)
