"""Verification against synthetic logs whose errors and faults are known."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from synthetic_logs import START_UTC_S, Faults, Settings, synthetic_log

from benchmarks.independent_logs import Truth
from benchmarks.independent_logs import made as made_elsewhere
from missions.library import load_mission
from missions.logs.table import EulerAngles, log_from_table
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from solar.attitude_models import full_model
from solar.geometry import ModuleGeometry
from solar.horizontal_models import HORIZONTAL_MODELS
from studies.cli.__main__ import cli
from studies.flight_logs import plots
from studies.flight_logs.errors import Window, moving_average, parse_window, surfaces_of
from studies.flight_logs.estimates import Applied, Fit, estimates, level_power_key
from studies.flight_logs.forward import Forward
from studies.flight_logs.verification import verify

pytestmark = pytest.mark.slow

MORNING_S = START_UTC_S + 18.3 * 3600.0  # just before sunrise on 1 July
ATTITUDE = ["roll_deg", "pitch_deg", "yaw_deg"]
AS2, FLIGHT = load_aircraft("atlantiksolar-as2"), load_mission("rafz-28h")
RUN = {"aircraft.yaml", "mission.yaml", "run.json", "results.json"}


@cache
def made(**settings):
    """Return the rows of a log; tests that change them work on a copy."""
    return synthetic_log(AS2, FLIGHT, Settings(**({"rate_hz": 0.1} | settings)))


def logged(**settings):
    return log_from_table(made(**settings), "synthetic.csv")


def verified(rows, **options):
    return verify(AS2, log_from_table(rows, "synthetic.csv"), FLIGHT, **options)


# ---- Errors


@pytest.mark.parametrize("bias", [0.0, -0.08, 0.15])
def test_bias_is_recovered(bias):
    result = verified(made(rate_hz=0.5, bias=bias))
    assert [day.label for day in result.days] == ["2015-06-30", "2015-07-01"]
    for day in result.days:
        errors = day.models["FM"]
        # 18000 samples with 1 W of noise scatter by 0.008 W about a mean of some 150 W, and the
        # attitude's error of 0.2 deg (0.6 W, as most) by less: 0.05 % is several times that.
        assert errors["average_error_relative"] == pytest.approx(bias, abs=5e-4)
        assert errors["average_error_w"] == pytest.approx(
            errors["modelled_mean_w"] - day.measured_mean_w
        )


def test_errors_follow_their_definition():
    result = verified(made(start_utc_s=MORNING_S, duration_h=4.0), filter_s=0.0)
    (day,) = result.days
    samples = result.samples
    for model, errors in day.models.items():
        error = samples.modelled_w[model] - samples.measured_w
        assert errors["average_error_w"] == pytest.approx(error.mean())
        assert errors["rms_error_w"] == pytest.approx(np.sqrt((error**2).mean()))
        assert errors["maximum_error_w"] == pytest.approx(np.abs(error).max())


def test_moving_average_never_leaves_a_run():
    run = np.array([0, 0, 0, 0, 1, 1, 1, 2])
    values = np.array([1.0, 2.0, 3.0, 4.0, 100.0, 200.0, 300.0, 7.0])
    expected = [1.5, 2.0, 3.0, 3.5, 150.0, 200.0, 250.0, 7.0]
    time_s = 1.4e9 + 0.5 * np.arange(8)  # as large as in logs
    assert moving_average(values, run, time_s, 0.5) == pytest.approx(expected)
    assert moving_average(values, run, time_s, 0.0) == pytest.approx(values)
    assert moving_average(values, run, time_s, 999.0)[:5] == pytest.approx([2.5] * 4 + [200.0])


def test_all_models_agree_with_the_library_on_single_samples():
    """Chunks, areas and frames: each sample alone gives what the whole log gives."""
    log = logged(rate_hz=0.5, start_utc_s=MORNING_S, duration_h=6.0)
    result = verify(AS2, log, FLIGHT)
    modules = AS2.modules
    from solar.clearsky import clear_sky
    from solar.geometry import direction_cosines
    from solar.sun import sun_position

    for place in (10, 3000, 9000):
        i = result.samples.index[place]
        sun = sun_position(log.time_s[i], log.latitude_deg[i], log.longitude_deg[i])
        cosine = np.sin(sun.elevation_rad)
        day = 182.0 + (log.time_s[i] % 86400.0) / 86400.0
        light = clear_sky(day, log.latitude_deg[i], cosine, log.altitude_m[i])
        to_ned = direction_cosines(*(angle[i] for angle in log.attitude))
        full = full_model(light, sun.vector_ned, to_ned, modules.geometry, modules, 22.7)
        power = {m: f(light, cosine, modules, 22.7) for m, f in HORIZONTAL_MODELS.items()}
        power["FM"] = full.specific_power_w_per_m2
        for model, specific in power.items():
            expected = modules.area_m2 * float(specific)
            assert result.samples.modelled_w[model][place] == pytest.approx(expected, rel=1e-9)


def test_gap_is_not_filtered_over():
    faults = Faults(missing=(2.0, 2.5))
    result = verified(made(start_utc_s=MORNING_S, duration_h=4.0, faults=faults))
    before = result.samples.time_s < MORNING_S + 7200.0
    assert len(np.unique(result.samples.run)) == 2
    assert (result.samples.run[before] == 0).all()
    assert (result.samples.run[~before] == 1).all()


def test_ambient_temperature_of_log_then_mission_then_standard_air():
    log = made(start_utc_s=MORNING_S, duration_h=6.0)
    hot = log.assign(ambient_temperature_c=42.7)
    bare = log.drop(columns="ambient_temperature_c")
    plain = FLIGHT.model_copy(update={"air": type(FLIGHT.air)()})

    def warmest(table, where):
        detail = verify(AS2, log_from_table(table, "x"), where).samples.detail
        return float(detail["module_temperature_c"].max())

    of_mission = warmest(bare, FLIGHT)
    # The feedback of the temperature on power takes back a little of 20 K.
    assert warmest(hot, FLIGHT) - of_mission == pytest.approx(20.0, abs=0.8)
    # Standard air at 536 m has 11.5 C, 11.2 K less than the mission.
    assert warmest(bare, plain) - of_mission == pytest.approx(-11.2, abs=0.5)


# ---- What is left out


def reasons(result):
    return [item.reason for item in result.left_out]


@pytest.mark.parametrize("missing", [[], ["state_of_charge"], ["mppt_voltage_v"], ATTITUDE])
def test_of_a_clean_log_nothing_is_left_out(missing):
    result = verified(made(power_noise_w=3.0, jitter_deg=3.0).drop(columns=missing))
    assert result.left_out == ()
    assert not result.excluded.any()


@pytest.mark.parametrize("missing", [[], ATTITUDE, ["mppt_voltage_v"]])
def test_limited_power_is_left_out(missing):
    log = made(faults=Faults(battery_full=(24.0, 27.0)))
    result = verified(log.drop(columns=missing))
    assert reasons(result) == ["battery_full"]
    (full,) = result.left_out
    assert full.start_s == pytest.approx(START_UTC_S + 24.0 * 3600.0, abs=600.0)
    # Three hours at 0.1 Hz, widened by a few minutes.
    assert 1080 <= result.days[1].excluded_samples <= 1080 * 1.1
    if not missing:
        errors = result.days[1].models["FM"]
        assert errors["average_error_relative"] == pytest.approx(0.0, abs=1e-3)
        # The day's filter would otherwise carry 100 W and more across the edges.
        assert errors["maximum_error_w"] < 2.0
        half = log.assign(state_of_charge=0.5)
        assert reasons(verified(half)) == []


def test_without_a_charge_the_fall_of_power_to_the_load_is_left_out():
    """Charging power of 60 W that falls to nothing within three hours, and 20 minutes of that."""
    table = made(faults=Faults(battery_full=(24.0, 27.0)))
    hours = np.arange(len(table)) / 360.0
    held = (hours >= 27.0) & (hours < 27.33)
    power = np.where(
        held, np.minimum(table["solar_power_w"], table["load_w"]), table["solar_power_w"]
    )
    rows = table.assign(solar_power_w=power).drop(columns="state_of_charge")
    result = verified(rows)
    assert reasons(result) == ["battery_full"]
    inside = (result.samples.time_s > START_UTC_S + 24.1 * 3600.0) & result.excluded
    assert inside.sum() > 0.95 * 3.2 * 360
    # What is left of the fall moves the sun by less than a sixteenth of a degree.
    assert estimate(result, "clock_offset").value == pytest.approx(0.0, abs=0.25)


def test_no_power_is_left_out_and_dusk_is_not():
    table = made()
    hours = np.arange(len(table)) / 360.0
    dead = (hours > 3.0) & (hours < 3.5)
    noise = np.random.default_rng(1).normal(0.0, 0.5, len(table))
    rows = table.assign(solar_power_w=np.where(dead, noise, table["solar_power_w"]))
    result = verified(rows)
    (gone,) = result.left_out
    assert gone.reason == "no_power"
    assert gone.count == dead.sum()
    assert result.excluded.sum() == dead.sum()
    assert covers(result, "solar_factor", 1.0)


@pytest.mark.parametrize(
    ("missing", "left_out"), [((12.0, 13.0), {}), ((23.0, 23.5), {"missing_data": 1800.0})]
)
def test_gaps_by_day_are_told_and_those_at_night_are_not(missing, left_out):
    result = verified(made(faults=Faults(missing=missing)))
    assert len(result.log.gaps) == 1
    found = {gap.reason: gap.end_s - gap.start_s for gap in result.left_out}
    assert found == pytest.approx(left_out, abs=20.0)


# ---- Estimates


def estimate(result, name):
    return next(item for item in result.estimates if item.name == name)


def covers(result, name, truth):
    item = estimate(result, name)
    return item.low <= truth <= item.high


def altered(log, clock_min=0.0, heading_deg=0.0):
    """Log whose clock and compass are off."""
    times = pd.to_datetime(log["time_utc"]) + pd.Timedelta(minutes=clock_min)
    table = log.assign(
        time_utc=times.dt.strftime("%Y-%m-%dT%H:%M:%S.%fZ"),
        yaw_deg=(log["yaw_deg"] + heading_deg + 180.0) % 360.0 - 180.0,
    )
    return log_from_table(table, "altered.csv")


@pytest.mark.parametrize(("clock_min", "heading_deg"), [(0, 0), (37, 0), (-120, 90), (0, 8)])
def test_offsets_are_estimated_and_applied_on_request(clock_min, heading_deg):
    log = altered(made(bias=-0.0175), clock_min, heading_deg)
    result = verify(AS2, log, FLIGHT)
    truths = {"clock_offset": clock_min, "heading_offset": heading_deg, "solar_factor": 1 / 0.9825}
    for name, truth in truths.items():
        assert covers(result, name, truth), (name, estimate(result, name))
    assert result.log is log  # nothing is corrected
    clock, heading, factor = (estimate(result, name).apply for name in truths)
    assert (clock[0], heading[0]) == ("--clock-offset", "--heading-offset")
    applied = verify(
        load_aircraft("atlantiksolar-as2", [factor[1]]),
        log,
        FLIGHT,
        clock_offset_min=float(clock[1]),
        heading_offset_deg=float(heading[1]),
    )
    for name, truth in {"clock_offset": 0.0, "heading_offset": 0.0, "solar_factor": 1.0}.items():
        # About the half-width of the intervals: weights follow from the residuals, these from them.
        value = estimate(applied, name).value
        assert value == pytest.approx(truth, abs=0.01 if truth else 1.0)
    assert abs(applied.days[0].models["FM"]["average_error_w"]) < 0.5
    assert applied.to_dict()["applied"]["clock_min"] == float(clock[1])
    again = estimate(applied, "clock_offset").apply[1]
    assert float(again) == pytest.approx(float(clock[1]), abs=1.0)  # options replace each other


def test_without_attitude_a_clock_is_estimated_and_no_heading():
    log = altered(made(), 60.0)  # CAM errs by up to 7 % in wind
    result = verify(AS2, replace(log, attitude=None), FLIGHT)
    assert covers(result, "clock_offset", 60.0)
    heading = estimate(result, "heading_offset")
    assert heading.value is None
    assert heading.why == "the log has no attitude"
    assert result.correlation is None


def test_what_is_known_to_nothing_is_not_determined():
    log = logged(start_utc_s=MORNING_S, duration_h=3.0)
    level = replace(log, attitude=EulerAngles(*(0.01 * angle for angle in log.attitude or ())))
    forward = Forward(level, AS2, FLIGHT, np.arange(len(log)))
    names = ("factor", "clock_s", "heading")
    fit = Fit(names, np.zeros(3), np.diag([0.01, 7200.0, 1.0]) ** 2, 1.0)
    clock, heading, _, _ = estimates(forward, np.zeros(0, int), fit, Applied())
    assert clock.why == "known to ± 235 min only: the power of these 3.0 h does not tell it"
    assert "the wings are level to 0.0 deg" in heading.why
    assert clock.value is heading.value is None
    none = estimates(forward, np.zeros(0, int), None, Applied())
    assert none[0].why == "too few samples with power count"


@pytest.mark.parametrize(
    ("factor", "words"), [(1e-3, "as if the power was logged in kW"), (-1.0, "factor of -1")]
)
def test_units_and_signs_are_named(factor, words):
    log = logged()
    wrong = replace(log, solar_power_w=factor * log.solar_power_w)
    item = estimate(verify(AS2, wrong, FLIGHT), "solar_factor")
    assert words in item.why
    assert item.apply == ()


def test_power_of_level_flight_is_the_load_without_avionics():
    log = logged()  # 43 W in the mean, gusts of 2 W
    constant_w = design_of(AS2, FLIGHT).constant_power_w
    of_load = verify(AS2, log, FLIGHT)
    assert covers(of_load, "level_power", 43.0 - constant_w)
    (key,) = estimate(of_load, "level_power").apply[1:]
    craft = load_aircraft("atlantiksolar-as2", [key])
    value = estimate(of_load, "level_power").value
    assert design_of(craft, FLIGHT).propulsion_power_w == pytest.approx(value, rel=1e-3)
    balance = replace(log, load_w=None, battery_power_w=log.solar_power_w - log.load_w)
    assert estimate(verify(AS2, balance, FLIGHT), "level_power").value == pytest.approx(value)
    nothing = verify(AS2, replace(log, load_w=None), FLIGHT)
    assert estimate(nothing, "level_power").why == "neither load_w nor battery_power_w is logged"


def test_parametric_aircraft_have_a_key_for_the_power_of_level_flight():
    craft, where = load_aircraft("atlantiksolar-design"), FLIGHT
    power_w = 1.1 * design_of(craft, where).propulsion_power_w
    key, value = level_power_key(craft, where, power_w)
    again = load_aircraft("atlantiksolar-design", [f"{key}={value}"])
    assert design_of(again, where).propulsion_power_w == pytest.approx(power_w, rel=1e-4)
    assert "gives it" in level_power_key(craft, where, 1e6)


@pytest.mark.parametrize(
    ("number", "truth"),
    [(0, Truth()), (1, Truth("clock", 37.0)), (2, Truth("heading", 8.0)), (3, Truth(full=True))],
)
def test_intervals_hold_on_flights_of_another_simulation(number, truth):
    """Sun, sky, glass and temperatures of pvlib, turbidity of 2 to 5, attitude off by 0.3 deg."""
    rows = made_elsewhere(AS2, truth, 5000 + number).rows
    result = verified(rows)
    for name in ("clock", "heading"):
        item = estimate(result, f"{name}_offset")
        # Three standard errors: two, the interval, are passed by one in twenty.
        error = item.value - (truth.size if truth.cause == name else 0.0)
        assert abs(error) < 1.5 * (item.high - item.value), item


def test_residuals_are_errors_of_bins():
    result = verified(made(start_utc_s=MORNING_S, duration_h=6.0, bias=-0.05))
    samples, verification = result.samples, result.residuals
    inside = (samples.elevation_deg >= 30.0) & (samples.elevation_deg < 40.0)
    row = next(item for item in verification["morning"].itertuples() if item.low == 30.0)
    assert row.samples == inside.sum()
    measured = samples.measured_w[inside].mean()
    assert row.as_logged == pytest.approx(samples.modelled_w["FM"][inside].mean() / measured - 1.0)
    assert verification["afternoon"].empty
    bright = (samples.measured_w > 0.02 * samples.measured_w.max()).sum()
    for name in ("time", "morning", "bearing"):
        rows = list(verification[name].itertuples())
        assert bright <= sum(item.samples for item in rows) <= len(samples.time_s)
        for item in rows[1:]:  # the first hour has hardly any light
            assert item.as_logged == pytest.approx(-0.05, abs=0.02)
            assert item.estimated == pytest.approx(0.0, abs=0.02)


def test_dead_modules_are_seen_beside_the_other_mppts():
    log = logged(start_utc_s=MORNING_S, duration_h=6.0)
    forward = Forward(log, AS2, FLIGHT, np.arange(len(log)))
    each = forward.power_by_surface_w()
    assert each.sum(axis=1) == pytest.approx(forward.power_w(), abs=1e-6)
    power = {f"P {side}": each[:, i : i + 2].sum(axis=1) for i, side in
             ((0, "left"), (2, "centre"), (4, "right"))}  # fmt: skip
    power["P right"] = 0.5 * power["P right"]
    log = replace(log, mppt_power_w=power, solar_power_w=np.sum(list(power.values()), axis=0))
    result = verify(AS2, log, FLIGHT)
    each = result.mppts.each
    assert [item.modules[0] for item in each] == ["left front", "centre front", "right front"]
    assert [item.ratio for item in each] == pytest.approx([1.0, 1.0, 0.5], abs=1e-6)
    assert "power of the MPPTs; their modules by name" in str(result.at_level(2))
    assert len(plots.residual_figure(result).axes) == 5


def test_mppts_are_matched_by_name_by_number_or_in_order():
    log, surfaces = logged(), load_aircraft("atlantiksolar-as2").modules.geometry

    def matched(names, where):
        power = dict.fromkeys(names, log.solar_power_w)
        wiring, how = surfaces_of(replace(log, mppt_power_w=power), where)
        return None if wiring is None else wiring.astype(int).tolist(), how

    six = matched([f"mppt {i}" for i in range(6)], surfaces)
    assert six == (np.eye(6).tolist(), "in the order of the surfaces")
    named = [[0, 0, 0, 0, 1, 1], [0, 0, 1, 1, 0, 0], [1, 1, 0, 0, 0, 0]]
    assert matched(["P right [W]", "P middle [W]", "P left [W]"], surfaces) == (named, "by name")
    none, why = matched(["a", "b"], surfaces)
    assert none is None
    assert "2 columns, 6 surfaces" in why
    rows = surfaces.model_dump()
    for place, surface in enumerate(rows["surfaces"]):
        surface["mppt"] = 1 + place % 2
    wired = [[1, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 1]]
    by_key = matched(["a", "b"], ModuleGeometry.model_validate(rows))
    assert by_key == (wired, "by the surfaces' mppt")
    assert matched([], surfaces) == (None, "")


# ---- What cannot be computed


def test_without_attitude_vm_and_fm_are_refused_and_the_rest_is_computed():
    log = made(start_utc_s=MORNING_S, duration_h=4.0)
    result = verified(log.drop(columns=ATTITUDE))
    assert list(result.samples.modelled_w) == ["CDM", "CAM"]
    assert any("VM and FM are not computed: the log has no attitude" in n for n in result.notes)
    whole = verified(log)
    assert result.samples.modelled_w["CAM"] == pytest.approx(whole.samples.modelled_w["CAM"])


@pytest.mark.parametrize("part", ["geometry", "tail"])
def test_parts_that_are_not_modelled_are_told(part):
    modules = AS2.modules.model_copy(update={part: None})
    log = logged(start_utc_s=MORNING_S, duration_h=2.0)
    bare = verify(AS2.model_copy(update={"modules": modules}), log, FLIGHT)
    assert f"has no modules.{part}" in " ".join(bare.notes)
    assert not any(part in note for note in verify(AS2, log, FLIGHT).notes)


@pytest.mark.parametrize(
    ("start_utc_s", "windows", "message"),
    [
        (START_UTC_S + 12 * 3600.0, [], "the sun never rises in this log"),
        (MORNING_S, [Window(15, 16)], r"window 15 to 16 h .*allowed: 2015-07-01 4\.1"),
        (MORNING_S, ["9:8"], "must be a:b in solar hours"),
    ],
)
def test_logs_and_windows_without_samples_are_refused(start_utc_s, windows, message):
    log = made(start_utc_s=start_utc_s, duration_h=3.0)
    with pytest.raises(ValueError, match=message):
        verified(log, windows=windows)


@pytest.mark.parametrize("text", ["6", "7:6", "5:25", "a:b", "5:6:7", "2015-02-30@5:6", "-1:4"])
def test_bad_window(text):
    with pytest.raises(ValueError, match=r"must be a:b in solar hours|there is no date"):
        parse_window(text)


# ---- Command


@pytest.fixture(scope="module")
def log_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("log") / "flight.csv"
    faults = Faults(battery_full=(4.0, 5.0))
    file.write_text(
        made(start_utc_s=MORNING_S, duration_h=6.0, rate_hz=0.2, faults=faults).to_csv(index=False)
    )
    return file


def run(*arguments):
    return CliRunner().invoke(cli, ["verify", "atlantiksolar-as2", *map(str, arguments)])


def test_command_prints_json(log_file):
    result = run(log_file, "--json", "--window", "5.7:5.8", "--filter", "7")
    record = json.loads(result.output)
    assert [s["filter_s"] for s in (*record["windows"], *record["days"])] == [7, 7]
    assert record["models"] == ["CDM", "CAM", "VM", "FM"]
    assert [item["reason"] for item in record["left_out"]] == ["battery_full"]
    assert set(record["estimates"]) == {
        "clock_offset", "heading_offset", "solar_factor", "level_power",
    }  # fmt: skip
    assert set(record["residuals"]) == {"time", "morning", "afternoon", "bearing"}
    assert record["excluded_samples"] > 600


def test_command_writes_everything(log_file, tmp_path):
    out = tmp_path / "deep" / "out"
    result = run(log_file, "--out", out, "--window", "5.7:5.8", "--window", "2015-07-01@8:8.1")
    assert result.exit_code == 0, result.output
    images = {"residuals.png", "window-1.png", "window-2.png"}
    assert {f.name for f in out.iterdir()} == images | RUN | {"samples.csv"}
    assert {f.name for f in out.parent.iterdir()} == {"out"}
    for name in images:
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    table = pd.read_csv(out / "samples.csv")
    record = json.loads((out / "results.json").read_text())
    assert len(table) == record["log"]["sunlit_samples"]
    used = table[table["excluded"] == 0]
    mean = record["days"][0]["models"]["FM"]["average_error_w"]
    # The file has milliwatts.
    assert used["fm_error_w"].mean() == pytest.approx(mean, abs=1e-3)
    assert (table["fm_w"] - table["solar_power_w"]).to_numpy() == pytest.approx(
        table["fm_error_w"].to_numpy(), abs=2e-3
    )


def test_printed_options_run_as_printed(log_file):
    printed = [line.strip() for line in run(log_file).output.splitlines()]
    start = printed.index("to apply an estimate, add its option:")
    options = [line for line in printed[start + 1 :] if line.startswith("--")]
    assert len(options) == 4
    result = run(log_file, *" ".join(options).split())
    assert result.exit_code == 0, result.output
    assert "as asked for" in " ".join(result.output.split())


def test_figures_show_what_is_left_out(log_file):
    result = verify(AS2, str(log_file), FLIGHT, windows=[Window(5.0, 6.0)])
    drawn = plots.residual_figure(result)
    assert [axes.get_xlabel() for axes in drawn.axes] == [
        *["time of 2015-07-01 [h UTC]"] * 2,
        "elevation of the sun [deg]",
        "azimuth of the sun from the nose, clockwise [deg]",
    ]
    legend = drawn.axes[0].get_legend()
    assert [t.get_text() for t in legend.get_texts()] == [
        "CDM", "CAM", "VM", "FM", "measured", "battery full",
    ]  # fmt: skip
    power, error = plots.window_figure(result, 0).axes
    measured = power.lines[-1].get_ydata()
    for line, other in zip(power.lines, error.lines, strict=False):
        if line.get_label() != "measured":
            assert other.get_ydata() == pytest.approx(line.get_ydata() - measured, nan_ok=True)
    no_attitude = verify(AS2, replace(result.log, attitude=None), FLIGHT)
    assert len(plots.residual_figure(no_attitude).axes) == 3


def test_result_prints_itself_and_reads_its_own_log(log_file):
    result = verify(AS2, log_file, windows=["5.71:5.79"])
    assert result.mission == "rafz-28h"
    assert len(str(result).splitlines()) <= 25
    text = " ".join(str(result.at_level(2)).split())  # the path may be wider than a line
    assert text.startswith(f"atlantiksolar-as2 against {log_file}")
    for part in ("5.71 to 5.79 h (solar time)", "2015-07-01 (UTC)", "battery full", "left out"):
        assert part in text
    assert repr(result) == f"<Verification: {result.headline()}>"
    frame = result.to_frame()
    assert len(frame) == result.to_dict()["log"]["sunlit_samples"]
    assert frame["fm_w"].to_numpy() == pytest.approx(result.samples.modelled_w["FM"])
    assert result.to_csv().count("\n") == len(frame) + 1


def test_a_log_in_the_folder_of_results_is_not_overwritten(tmp_path):
    log = tmp_path / "samples.csv"
    log.write_text("a flight that is not flown again")
    done = run(log, "--out", tmp_path)
    assert done.exit_code == 2
    assert "is read by this command" in done.output
    assert log.read_text() == "a flight that is not flown again"
