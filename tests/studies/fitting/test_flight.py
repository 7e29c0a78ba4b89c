"""Fits of synthetic flights whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR

from missions.files.errors import InputError
from missions.library import load_mission
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.energy.battery import Store
from studies.fitting.channels.bins import Bins, long_stretches
from studies.fitting.flight import FlightFit, fit_flight
from studies.fitting.parameters import PARAMETERS, chosen, default_names, replaced_values
from studies.fitting.prediction import predict_flight
from studies.fitting.synthetic import Errors, Flight, fly

NAMES = ("module_efficiency", "temperature_rise", "level_power", "specific_energy")
TRUTH = (0.222, 16.0, 38.5, 238.0)
NONE = Errors(*(0.0,) * 3, 0.0, 1.0, 0.0, 0.0, 1.0)
QUIET = replace(NONE, haze_h=1.0)
SHORT = Flight(duration_h=26.0, step_s=60.0, errors=QUIET)


@cache
def mission() -> Mission:
    return load_mission("rafz-28h")


def truth() -> Aircraft:
    return replaced_values(AS2, tuple(PARAMETERS[name] for name in NAMES), TRUTH)


@cache
def quiet_log() -> FlightLog:
    return fly(truth(), mission(), SHORT).log()


@cache
def noisy_log() -> FlightLog:
    noise = Errors(haze=0.01)
    return fly(truth(), mission(), Flight(seed=3, duration_h=52.0, errors=noise)).log()


@cache
def fitted(*names: str) -> FlightFit:
    return fit_flight(AS2, noisy_log(), mission(), correct=None, names=names)


def test_a_flight_without_errors_gives_the_truth() -> None:
    warm = replaced_values(AS2, (PARAMETERS["temperature_rise"],), (TRUTH[1],))
    fit = fit_flight(warm, quiet_log(), mission(), correct=None, light_sigma=0.0)
    found = {one.parameter.name: one.value for one in fit.fitted}
    # The log's attitude errs by 0.2 degrees, half a per cent of the power from a low sun, which the
    # fit may take for two per cent of haze.
    assert found["module_efficiency"] == pytest.approx(TRUTH[0], rel=2e-2)
    assert fit.fitted[0].low < TRUTH[0] < fit.fitted[0].high
    # The warmth of the modules does what haze does: a flight does not tell them apart.
    assert "temperature_rise" in {one.parameter.name for one in fit.held}
    # Loads and charges are written down with two and four digits, altitudes err by a metre.
    assert found["level_power"] == pytest.approx(TRUTH[2], rel=1e-3)
    assert found["specific_energy"] == pytest.approx(TRUTH[3], rel=3e-3)


def test_intervals_of_a_noisy_flight_hold_the_truth_and_are_narrower_than_before() -> None:
    fit = fitted()
    assert {one.parameter.name for one in fit.fitted} >= {"level_power", "specific_energy"}
    for one in fit.fitted:
        assert one.low <= TRUTH[NAMES.index(one.parameter.name)] <= one.high
        assert one.half_width >= 1.9 * one.standard_error
    for part in fit.estimates:
        assert np.mean(part.solution.residual**2) < np.mean(part.before**2)
        assert part.solution.independent < 0.5 * len(part.solution.residual)


def test_the_light_widens_the_intervals_of_the_modules_alone() -> None:
    wide = fit_flight(AS2, noisy_log(), mission(), correct=None, light_sigma=0.10)
    errors = {
        sigma: {one.parameter.name: one.standard_error for one in fit.fitted}
        for sigma, fit in ((0.03, fitted()), (0.10, wide))
    }
    module = [errors[sigma]["module_efficiency"] for sigma in (0.03, 0.10)]
    # A tenth more light is a tenth more efficiency; weights differ a little.
    assert module[1] ** 2 - module[0] ** 2 == pytest.approx(
        (0.10**2 - 0.03**2) * fitted().fitted[0].value ** 2, rel=0.1
    )
    assert errors[0.10]["level_power"] == errors[0.03]["level_power"]


@pytest.mark.parametrize(
    ("names", "held"),
    [
        (("module_efficiency", "mppt_efficiency"), "mppt_efficiency"),
        (("mppt_efficiency", "module_efficiency"), "module_efficiency"),
        (("level_power", "avionics_power"), "avionics_power"),
        (
            ("specific_energy", "charge_efficiency", "discharge_efficiency"),
            "discharge_efficiency",
        ),
    ],
)
def test_of_what_cannot_be_told_apart_the_later_one_is_held(
    names: tuple[str, ...], held: str
) -> None:
    fit = fitted(*names)
    reasons = {one.parameter.name: one.reason for one in fit.held}
    assert "the log cannot tell it from" in reasons[held]
    assert "collinearity index" in reasons[held]
    if names[0] != "mppt_efficiency":  # known to 10 % before, which is less than the sky is
        assert names[0] in {one.parameter.name for one in fit.fitted}
    assert all(part.collinearity <= 20.0 for part in fit.estimates)


def test_mppt_efficiency_moves_the_curve_that_the_full_model_reads() -> None:
    one = PARAMETERS["mppt_efficiency"]
    halved = one.applied(AS2, 0.5 * AS2.modules.mppt_efficiency)
    loads = np.linspace(0.0, 1.0, 11)
    assert halved.modules.mppt_efficiency_at(loads) == pytest.approx(
        0.5 * AS2.modules.mppt_efficiency_at(loads), rel=1e-3
    )


def test_without_attitude_the_temperature_plays_no_part() -> None:
    fit = fit_flight(AS2, replace(quiet_log(), attitude=None), mission(), correct=None)
    (rise,) = (one for one in fit.held if one.parameter.name == "temperature_rise")
    assert "plays no part in the solar power (CAM)" in rise.reason
    assert any("CAM, whose own error (RMS 7 % of" in note for note in fit.notes)


def test_what_the_log_lacks_is_held_with_the_reason() -> None:
    bare = replace(quiet_log(), load_w=None, state_of_charge=None)
    fit = fit_flight(AS2, bare, mission(), correct=None)
    reasons = {one.parameter.name: one.reason for one in fit.held}
    assert reasons["level_power"] == "the log has no load_w"
    assert reasons["specific_energy"] == "the log has no state_of_charge"


def test_power_that_a_full_battery_holds_back_is_not_taken_for_the_modules() -> None:
    log = quiet_log()
    assert log.state_of_charge is not None
    fit = fit_flight(AS2, log, mission(), correct=None, light_sigma=0.0)
    solar = next(part for part in fit.estimates if part.channel.name == "solar")
    charge = np.interp(solar.channel.time_s, log.time_s, log.state_of_charge)
    assert charge.max() < 0.99
    assert any("may be limited" in note for note in fit.notes)


def test_load_is_of_the_night_and_level() -> None:
    log = quiet_log()
    assert log.load_w is not None
    dark = log.solar_power_w < 5.0
    work = replace(log, load_w=log.load_w + np.where(dark, 0.0, 30.0))
    assert level_power(fit_flight(AS2, work, mission(), correct=None)) == pytest.approx(
        TRUTH[2], rel=1e-3
    )
    # 600 m up and down again in two hours of the night, the climb on 60 W.
    hours = (log.time_s - log.time_s[np.flatnonzero(dark)[len(dark[dark]) // 2]]) / 3600.0
    up = (hours > -1.0) & (hours < 0.0)
    altitude_m = log.altitude_m + 600.0 * np.clip(1.0 - np.abs(hours), 0.0, 1.0)
    climbs = replace(work, altitude_m=altitude_m, load_w=work.load_w + np.where(up, 60.0, 0.0))
    # The density changes with the height: what is left of it at the ends of the climb.
    assert level_power(fit_flight(AS2, climbs, mission(), correct=None)) == pytest.approx(
        TRUTH[2], rel=1e-2
    )


def level_power(fit: FlightFit) -> float:
    return next(one.value for one in fit.fitted if one.parameter.name == "level_power")


def test_defaults_follow_the_kind_of_aircraft() -> None:
    assert default_names(AS2)[2] == "level_power"
    assert default_names(SKY_SAILOR)[2] == "profile_drag"
    assert default_names(DESIGN)[2] == "profile_drag"
    with pytest.raises(ValueError, match=r"has no airframe\.level_flight\.electric_power_w"):
        chosen(("level_power",), DESIGN)
    with pytest.raises(ValueError, match="'span' cannot be fitted"):
        chosen(("span",), AS2)


def test_a_parametric_aircraft_is_fitted_by_its_drag() -> None:
    fit = fit_flight(DESIGN, quiet_log(), mission(), correct=None, names=("profile_drag",))
    craft = fit.fitted_aircraft()
    assert fit.fitted[0].value > PARAMETERS["profile_drag"].value(DESIGN)
    (part,) = fit.estimates
    assert np.abs(part.channel.residual(craft)).max() < 0.5


def test_another_flight_is_predicted_better_than_by_the_file() -> None:
    later = Flight(SHORT.start_utc_s + 14 * 86400.0, 26.0, 0.5, 60.0, errors=QUIET)
    night = fly(truth(), mission(), later)
    fit = fit_flight(AS2, quiet_log(), mission(), correct=None, light_sigma=0.0)
    found = predict_flight(fit, night.log("night.csv"), mission(), correct=None)
    # The charge is marched on means of a minute, over one orbit each.
    assert found.after.minimum_charge == pytest.approx(night.minimum_charge, abs=0.01)
    assert abs(found.before.minimum_charge - night.minimum_charge) > 0.05
    # The sky of the other flight: 3 % of it, haze and diffuse light are 30 Wh of 700.
    assert found.minimum_charge_error < 0.06


@pytest.mark.parametrize(("start_h", "begins"), [(9.0, 0.35), (19.0, 0.97), (15.5, 0.6)])
def test_least_charge_is_that_of_the_nights_whenever_a_flight_begins(
    start_h: float, begins: float
) -> None:
    # Over two nights from the morning, the evening or the afternoon.
    midnight = SHORT.start_utc_s // 86400.0 * 86400.0
    hours = 33.0 if start_h > 12.0 else 42.0
    flight = Flight(midnight + 3600.0 * start_h, hours, begins, 60.0, errors=QUIET)
    log = fly(truth(), mission(), flight).log("nights.csv")
    assert log.state_of_charge is not None
    fit = fit_flight(truth(), quiet_log(), mission(), correct=None)
    found = predict_flight(fit, log, mission(), correct=None)
    dark = log.solar_power_w < 1.0
    least = float(log.state_of_charge[np.argmax(dark) :].min())
    # Means over five minutes, of 0.5 % of charge each.
    assert found.measured.minimum_charge == pytest.approx(least, abs=0.006)
    assert found.after.minimum_charge == pytest.approx(least, abs=0.03)


def test_two_flights_are_fitted_together() -> None:
    names = ("module_efficiency", "level_power", "specific_energy")
    later = Flight(SHORT.start_utc_s + 30 * 86400.0, 26.0, 0.5, 60.0, seed=9, errors=QUIET)
    second = fly(truth(), mission(), later).log("second.csv")
    both = fit_flight(AS2, (quiet_log(), second), mission(), correct=None, names=names)
    alone = fit_flight(AS2, quiet_log(), mission(), correct=None, names=names)
    assert [one.source for one in both.logs] == ["synthetic.csv", "second.csv"]
    assert both.fitted[0].half_width < alone.fitted[0].half_width
    for part in both.estimates:
        assert len(part.solution.flights) == 2
        assert part.solution.chi_square < 6.63  # one in a hundred of one degree of freedom
    found = {one.parameter.name: one for one in both.fitted}
    one = found["module_efficiency"]
    assert one.low <= TRUTH[0] <= one.high
    # As of one flight: the logs have two digits and four.
    assert found["level_power"].value == pytest.approx(TRUTH[2], rel=1e-3)
    assert found["specific_energy"].value == pytest.approx(TRUTH[3], rel=3e-3)
    sky = {one.known.flight for one in both.estimates[0].errors if one.known.name == "haze"}
    assert sky == {0, 1}
    text = str(both)
    assert "what each flight adds" in text
    assert "probability" in text
    with pytest.raises(InputError, match="is the same flight as"):
        fit_flight(AS2, (quiet_log(), second, quiet_log()), mission(), correct=None, names=names)


def test_synthetic_flights_keep_their_energy() -> None:
    flown = fly(AS2, mission(), SHORT)
    solar, load, charge = (
        flown.table[name].to_numpy() for name in ("solar_power_w", "load_w", "state_of_charge")
    )
    store = Store.of(AS2.battery)
    net = (solar - load)[:-1] * SHORT.step_s / 3600.0
    gained = np.where(net > 0.0, net * store.charge_efficiency, net / store.discharge_efficiency)
    stored = charge[0] + np.cumsum(gained) / float(store.battery_energy_wh)
    # Powers are written down to 0.01 W.
    assert stored == pytest.approx(charge[1:], abs=2e-4)


def test_bins_end_where_stretches_do() -> None:
    time_s = np.concatenate((np.arange(0.0, 900.0, 60.0), np.arange(4000.0, 4600.0, 60.0)))
    run = (time_s > 2000.0).astype(int)
    bins = Bins.of(time_s, run, np.ones(len(time_s), bool))
    assert bins.counts.sum() == len(time_s)
    assert (bins.run[0], bins.run[-1]) == (0, 1)
    assert bins.mean(time_s)[0] == pytest.approx(120.0)
    assert long_stretches(time_s, run, 700.0).tolist() == (run == 0).tolist()
