"""Verification against synthetic logs whose errors and faults are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from missions.files.errors import InputError
from missions.library import load_mission
from missions.logs.table import log_from_table
from missions.mission import Mission
from sizing.aircraft import Aircraft, SolarModules
from sizing.library import load_aircraft
from solar.attitude_models import full_model
from solar.geometry import ModuleGeometry, ModuleOutline
from solar.horizontal_models import HORIZONTAL_MODELS
from solar.shading import TailGeometry, shaded_area
from solar.types import FloatArray
from studies.cli.__main__ import cli
from studies.flight_logs.errors import ModelErrors, Window, day_masks, moving_average, parse_window
from studies.flight_logs.synthetic import START_UTC_S, Faults, Settings, SyntheticLog, synthetic_log
from studies.flight_logs.verdict import model_sentence
from studies.flight_logs.verification import Verification, verify

pytestmark = pytest.mark.slow

MORNING_S = START_UTC_S + 18.3 * 3600.0  # just before sunrise on 1 July
ATTITUDE = ["roll_deg", "pitch_deg", "yaw_deg"]
RUN = {"aircraft.yaml", "mission.yaml", "run.json", "results.json"}


class ModulesWithTail(SolarModules):
    tail: TailGeometry | None = None


@cache
def aircraft() -> Aircraft:
    return load_aircraft("atlantiksolar-as2")


@cache
def mission() -> Mission:
    return load_mission("rafz-28h")


@cache
def geometry() -> ModuleGeometry:
    """Geometry of the aircraft with made-up outlines of about the right place and size."""
    bare = aircraft().modules.geometry
    assert bare is not None
    spans = {"centre": (-0.9, 0.9), "left": (0.95, 2.1), "right": (0.95, 2.1)}
    surfaces = []
    for surface in bare.surfaces:
        front = 0.02 if "front" in surface.name else 0.16
        outline = ModuleOutline(
            inboard_m=spans[surface.side][0],
            outboard_m=spans[surface.side][1],
            front_m=front,
            rear_m=front + 0.13,
        )
        surfaces.append(surface.model_copy(update={"outline": outline}))
    return bare.model_copy(update={"surfaces": tuple(surfaces)})


TAIL = TailGeometry(
    horizontal_span_m=0.9,
    horizontal_chord_m=0.2,
    horizontal_aft_m=1.3,
    vertical_height_m=0.45,
    vertical_chord_m=0.2,
    vertical_aft_m=1.3,
)


def shade(sun: FloatArray) -> FloatArray:
    return shaded_area(geometry(), TAIL, sun)


@cache
def made(**settings: Any) -> SyntheticLog:
    """Return a log; tests that change its table work on a copy."""
    return synthetic_log(aircraft(), mission(), Settings(**({"rate_hz": 0.5} | settings)))


def verified(log: SyntheticLog, **options: Any) -> Verification:
    return verify(aircraft(), log.log(), mission(), **options)


def without(log: SyntheticLog, *columns: str) -> Verification:
    table = log.table.drop(columns=list(columns))
    return verify(aircraft(), log_from_table(table, "synthetic.csv"), mission())


# ---- Errors


@pytest.mark.parametrize("bias", [0.0, -0.08, 0.15])
def test_bias_is_recovered(bias: float) -> None:
    result = verified(made(bias=bias))
    assert [day.label for day in result.days] == ["2015-06-30", "2015-07-01"]
    for day in result.days:
        errors = day.errors["FM"]
        # 18000 samples with 1 W of noise scatter by 0.008 W about a mean of some 150 W, and the
        # attitude's error of 0.2 deg (0.6 W, as most) by less: 0.05 % is several times that.
        assert errors.relative(errors.average_w) == pytest.approx(bias, abs=5e-4)
        assert errors.average_w == pytest.approx(errors.modelled_mean_w - errors.measured_mean_w)


def test_errors_follow_their_definition() -> None:
    result = verified(made(start_utc_s=MORNING_S, duration_h=4.0), filter_s=0.0)
    (day,) = result.days
    samples = result.samples
    for model, errors in day.errors.items():
        error = samples.modelled_w[model] - samples.measured_w
        assert errors.average_w == pytest.approx(error.mean())
        assert errors.rms_w == pytest.approx(np.sqrt((error**2).mean()))
        assert errors.maximum_w == pytest.approx(np.abs(error).max())


def test_filter_lowers_rms_but_not_the_average() -> None:
    log = made(start_utc_s=MORNING_S, duration_h=4.0)
    raw, smooth = (verified(log, filter_s=s).days[0].errors["CAM"] for s in (0.0, 400.0))
    assert smooth.average_w == pytest.approx(raw.average_w)
    assert smooth.rms_w < 0.9 * raw.rms_w
    assert smooth.maximum_w < raw.maximum_w


def test_moving_average_never_leaves_a_run() -> None:
    run = np.array([0, 0, 0, 0, 1, 1, 1, 2])
    values = np.array([1.0, 2.0, 3.0, 4.0, 100.0, 200.0, 300.0, 7.0])
    expected = [1.5, 2.0, 3.0, 3.5, 150.0, 200.0, 250.0, 7.0]
    time_s = 1.4e9 + 0.5 * np.arange(8)  # as large as in logs
    assert moving_average(values, run, time_s, 0.5) == pytest.approx(expected)
    assert moving_average(values, run, time_s, 0.0) == pytest.approx(values)
    assert moving_average(values, run, time_s, 999.0)[:5] == pytest.approx([2.5] * 4 + [200.0])


def test_moving_average_counts_seconds_at_any_rate() -> None:
    """A straight line is its own average over any symmetric window, at uneven steps as well."""
    for step_s in (0.1, 10.0):
        time_s = 1.4e9 + step_s * np.arange(400)
        line = moving_average(time_s - 1.4e9, np.zeros(400, int), time_s, 40.0)
        inside = slice(int(40 / step_s), -int(40 / step_s) or None)
        assert line[inside] == pytest.approx((time_s - 1.4e9)[inside])


def test_filter_of_a_slow_log_is_as_long_as_that_of_a_fast_one() -> None:
    slow, fast = (made(rate_hz=rate, duration_h=6.0) for rate in (0.1, 2.0))
    worst = [verified(log).days[0].errors["FM"].maximum_w for log in (slow, fast)]
    # Of noise of 1 W, the mean over 800 s has 0.11 W left of 81 samples and 0.03 W of 1601.
    assert worst[0] < 0.7
    assert worst[1] < 0.7


def test_all_models_agree_with_the_library_on_single_samples() -> None:
    """Chunks, areas and frames: each sample alone gives what the whole log gives."""
    log = made(start_utc_s=MORNING_S, duration_h=6.0).log()
    result = verify(aircraft(), log, mission())
    modules = aircraft().modules
    assert modules.geometry is not None
    assert log.attitude is not None
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


def test_models_order_as_in_the_report() -> None:
    """The report's morning: CDM well above CAM, CAM above VM in easterly wind, VM near FM."""
    result = verified(made(), windows=[parse_window("2015-07-01@4.17:9.72")])
    errors = result.windows[0].errors
    cdm, cam, vm = (errors[m].relative(errors[m].average_w) or 0.0 for m in ("CDM", "CAM", "VM"))
    # Published relative to FM: +19.9 %, +7.2 % and -0.2 %. Radius and speed of the circle are not.
    assert cdm == pytest.approx(0.199, abs=0.03)
    assert cam == pytest.approx(0.072, abs=0.03)
    assert vm == pytest.approx(-0.002, abs=0.03)
    # Published mean power of the Full Model.
    assert errors["FM"].modelled_mean_w == pytest.approx(97.87, rel=0.03)


def test_windows_of_every_day_and_of_one() -> None:
    log = made(rate_hz=0.1)
    every, one = verified(log, windows=[Window(10, 12), parse_window("2015-07-01@10:12")]).windows
    # On the first day the aircraft starts at 9.7 h solar time.
    assert every.samples == pytest.approx(2 * one.samples, rel=0.02)
    assert one.label == "2015-07-01, 10 to 12 h"
    assert one.filter_s == 1.0


def test_gap_is_not_filtered_over() -> None:
    faults = Faults(missing=(2.0, 2.5))
    result = verified(made(start_utc_s=MORNING_S, duration_h=4.0, faults=faults))
    before = result.samples.time_s < MORNING_S + 7200.0
    assert len(np.unique(result.samples.run)) == 2
    assert (result.samples.run[before] == 0).all()
    assert (result.samples.run[~before] == 1).all()


def test_ambient_temperature_of_log_then_mission_then_standard_air() -> None:
    log = made(start_utc_s=MORNING_S, duration_h=6.0)
    hot = log.table.assign(ambient_temperature_c=42.7)
    bare = log.table.drop(columns="ambient_temperature_c")
    plain = mission().model_copy(update={"air": type(mission().air)()})

    def warmest(table: pd.DataFrame, where: Mission) -> float:
        detail = verify(aircraft(), log_from_table(table, "x"), where).samples.detail
        assert detail is not None
        return float(detail.module_temperature_c.max())

    of_mission = warmest(bare, mission())
    # The feedback of the temperature on power takes back a little of 20 K.
    assert warmest(hot, mission()) - of_mission == pytest.approx(20.0, abs=0.8)
    # Standard air at 536 m has 11.5 C, 11.2 K less than the mission.
    assert warmest(bare, plain) - of_mission == pytest.approx(-11.2, abs=0.5)


# ---- Anomalies


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shading", [None, shade])
def test_clean_log_raises_none(
    seed: int, shading: Callable[[FloatArray], FloatArray] | None
) -> None:
    for settings in ({"rate_hz": 0.5}, {"rate_hz": 0.1, "power_noise_w": 3.0, "jitter_deg": 3.0}):
        assert verified(made(seed=seed, **settings), shading=shading).anomalies == ()


@pytest.mark.parametrize("bias", [-0.15, 0.15])
def test_constant_bias_is_no_anomaly(bias: float) -> None:
    assert verified(made(bias=bias), shading=shade).anomalies == ()


@pytest.mark.parametrize("missing", [["state_of_charge"], ["mppt_voltage_v"], ATTITUDE])
def test_clean_log_with_fewer_columns_raises_none(missing: list[str]) -> None:
    assert without(made(), *missing).anomalies == ()


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("kind", "faults", "overlap"),
    [
        # Before 5 h solar time the modules give less than 1 % of rated power, too little to judge.
        ("mppt_not_tracking", Faults(mppt=(18.5, 21.0)), 0.7),
        ("battery_full", Faults(battery_full=(24.0, 27.0)), 0.95),
        ("missing_data", Faults(missing=(23.0, 23.5)), 0.95),
        # The smallest shadows at either end cost less than the noise.
        ("shading", Faults(shading=shade), 0.6),
    ],
)
def test_injected_fault_is_found(seed: int, kind: str, faults: Faults, overlap: float) -> None:
    span: dict[str, Any] = {}
    if kind == "shading":  # morning and evening are two findings
        span = {"start_utc_s": MORNING_S, "duration_h": 6.0}
    log = made(seed=seed, faults=faults, **span)
    start_s, end_s = injected(faults, seed, **span)
    (found,) = verified(log, shading=shade).anomalies
    assert found.kind == kind
    common = min(found.end_s, end_s) - max(found.start_s, start_s)
    assert common > overlap * (end_s - start_s)
    # Not much more than what was injected either; smoothing widens a limit by minutes.
    assert found.end_s - found.start_s < 1.1 * (end_s - start_s)


def injected(faults: Faults, seed: int, **span: Any) -> tuple[float, float]:
    """Ends of the only fault of a log [s since 1970]: of a shadow, where it takes 1 %."""
    period = faults.mppt or faults.battery_full or faults.missing
    if period is None:
        logs = (made(seed=seed, faults=f, power_noise_w=0.0, **span) for f in (faults, Faults()))
        shaded, clear = (log.table["solar_power_w"].to_numpy() for log in logs)
        dark = np.flatnonzero(shaded < 0.99 * clear)
        period = (float(dark[0]) / 1800.0, float(dark[-1]) / 1800.0)  # two seconds each
    begin = float(span.get("start_utc_s", START_UTC_S))
    return begin + 3600.0 * period[0], begin + 3600.0 * period[1]


def test_limited_power_is_excluded_from_the_errors() -> None:
    result = verified(made(faults=Faults(battery_full=(24.0, 27.0))))
    day = result.days[1]
    # Three hours at 0.5 Hz, widened by a few minutes.
    assert 5400 <= day.excluded <= 5400 * 1.1
    errors = day.errors["FM"]
    assert errors.relative(errors.average_w) == pytest.approx(0.0, abs=1e-3)
    # The day's filter would otherwise carry 100 W and more across the edges.
    assert errors.maximum_w < 2.0


@pytest.mark.parametrize("missing", [ATTITUDE, ["mppt_voltage_v"]])
def test_limited_power_is_found_with_fewer_columns(missing: list[str]) -> None:
    (found,) = without(made(faults=Faults(battery_full=(24.0, 27.0))), *missing).anomalies
    assert found.kind == "battery_full"


@pytest.mark.parametrize("missing", [["state_of_charge"], ["state_of_charge", "load_w"]])
def test_without_a_charge_the_battery_is_among_what_may_be(missing: list[str]) -> None:
    found = without(made(faults=Faults(battery_full=(24.0, 27.0))), *missing)
    first = found.anomalies[0]
    assert first.kind == "mppt_not_tracking"
    assert "or the battery is nearly full (no state of charge is logged)" in first.evidence
    assert not found.corrected


def test_low_power_at_half_charge_is_not_blamed_on_the_battery() -> None:
    log = made(faults=Faults(battery_full=(24.0, 27.0)))
    table = log.table.assign(state_of_charge=0.5)
    result = verify(aircraft(), log_from_table(table, "x.csv"), mission())
    assert "battery_full" not in [a.kind for a in result.anomalies]
    assert not result.excluded.any()


def test_gap_at_night_is_no_anomaly() -> None:
    result = verified(made(faults=Faults(missing=(12.0, 13.0))))
    assert result.anomalies == ()
    assert len(result.log.gaps) == 1


def test_several_faults_are_told_apart() -> None:
    faults = Faults(mppt=(18.5, 21.0), battery_full=(24.0, 27.0), missing=(22.0, 22.2))
    found = [a.kind for a in verified(made(faults=faults)).anomalies]
    assert found == ["mppt_not_tracking", "missing_data", "battery_full"]


# ---- What cannot be computed


def test_without_attitude_vm_and_fm_are_refused_and_the_rest_is_computed() -> None:
    log = made(start_utc_s=MORNING_S, duration_h=4.0)
    result = without(log, *ATTITUDE)
    assert list(result.samples.modelled_w) == ["CDM", "CAM"]
    assert any("VM and FM are not computed: the log has no attitude" in n for n in result.notes)
    whole = verified(log)
    assert result.samples.modelled_w["CAM"] == pytest.approx(whole.samples.modelled_w["CAM"])


def test_aircraft_without_geometry() -> None:
    craft = load_aircraft("atlantiksolar-design")
    craft = craft.model_copy(
        update={"modules": craft.modules.model_copy(update={"geometry": None})}
    )
    log = made(start_utc_s=MORNING_S, duration_h=2.0)
    result = verify(craft, log.log(), mission())
    assert "has no modules.geometry" in result.notes[0]
    with pytest.raises(ValueError, match="no module geometry"):
        synthetic_log(craft, mission(), Settings())


def test_tail_of_the_aircraft_shades() -> None:
    plain = aircraft().modules.model_dump(exclude={"geometry", "tail"})
    log = made(start_utc_s=MORNING_S, duration_h=2.0)

    def result(**parts: Any) -> Verification:
        modules = ModulesWithTail(**plain, **parts)
        return verify(aircraft().model_copy(update={"modules": modules}), log.log(), mission())

    with_tail = result(geometry=geometry(), tail=TAIL).samples.detail
    assert with_tail is not None
    assert with_tail.shaded_m2 is not None
    assert with_tail.shaded_m2.max() > 0.05
    no_tail = result(geometry=geometry())
    assert no_tail.samples.detail is not None
    assert no_tail.samples.detail.shaded_m2 is None
    assert any("has no modules.tail" in note for note in no_tail.notes)


def test_log_by_night_is_refused() -> None:
    log = made(start_utc_s=START_UTC_S + 12 * 3600.0, duration_h=3.0)
    with pytest.raises(InputError, match="the sun never rises in this log"):
        verified(log)


def test_window_without_samples_is_refused() -> None:
    log = made(start_utc_s=MORNING_S, duration_h=3.0)
    with pytest.raises(InputError, match=r"window 15 to 16 h .*allowed: 2015-07-01 4\.1"):
        verified(log, windows=[Window(15, 16)])


@pytest.mark.parametrize("text", ["6", "7:6", "5:25", "a:b", "5:6:7", "2015-02-30@5:6", "-1:4"])
def test_bad_window(text: str) -> None:
    with pytest.raises(ValueError, match=r"must be a:b in solar hours|there is no date"):
        parse_window(text)


# ---- Command


@pytest.fixture(scope="module")
def log_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("log") / "flight.csv"
    faults = Faults(battery_full=(4.0, 5.0), shading=shade)
    file.write_text(
        made(start_utc_s=MORNING_S, duration_h=6.0, rate_hz=0.2, faults=faults).to_csv()
    )
    return file


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["verify", "atlantiksolar-as2", *map(str, arguments)])


def test_command_prints_tables(log_file: Path) -> None:
    result = run(log_file, "--window", "5.71:5.79")
    assert result.exit_code == 0, result.output
    for text in ("5.71 to 5.79 h", "CDM", "FM", "battery full", "ambient temperature: logged"):
        assert text in result.output


def test_name_of_a_log_is_text(log_file: Path, tmp_path: Path) -> None:
    odd = tmp_path / "[" / "x].csv"
    odd.parent.mkdir()
    odd.write_bytes(log_file.read_bytes())
    result = run(odd)
    assert result.exit_code == 0, result.output
    assert "[/x].csv" in "".join(result.output.split())


def test_folder_that_is_a_file_is_refused_before_any_work(log_file: Path) -> None:
    result = run("no-log.csv", "--out", log_file)
    assert isinstance(result.exception, OSError)
    assert "is not a folder" in str(result.exception)


def test_command_prints_json(log_file: Path) -> None:
    result = run(log_file, "--json", "--window", "5.7:5.8", "--filter", "7")
    record = json.loads(result.output)
    assert [s["filter_s"] for s in (*record["windows"], *record["days"])] == [7, 7]
    assert record["models"] == ["CDM", "CAM", "VM", "FM"]
    assert [a["kind"] for a in record["anomalies"]] == ["battery_full"]
    assert record["excluded_samples"] > 600


def test_command_writes_everything(log_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    result = run(log_file, "--out", out, "--window", "5.7:5.8", "--window", "2015-07-01@8:8.1")
    assert result.exit_code == 0, result.output
    images = {"window-1.png", "window-2.png", "day-2015-07-01.png"}
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


def test_figures_show_shade_and_exclusion(log_file: Path) -> None:
    from studies.flight_logs import plots

    log = made(
        start_utc_s=MORNING_S, duration_h=6.0, rate_hz=0.2, faults=Faults(battery_full=(4.0, 5.0))
    )
    result = verified(log, shading=shade, windows=[Window(5.0, 6.0)])
    ((_, mask),) = day_masks(result.samples)
    day = plots.day_figure(result, result.days[0], mask)
    labels = [axes.get_ylabel() for axes in day.axes]
    assert labels[0] == "solar power [W]"
    assert "shaded [cm²]" in labels
    legend = day.axes[0].get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()][-4:] == [
        "measured",
        "window",
        "excluded",
        "battery full",
    ]
    assert day.axes[-1].get_xlabel() == "time of 2015-07-01 [h UTC]"
    power, residuals = day.axes[:2]
    measured = power.lines[-1].get_ydata()
    for line, error in zip(power.lines, residuals.lines, strict=False):
        if line.get_label() != "measured":
            assert error.get_ydata() == pytest.approx(line.get_ydata() - measured, nan_ok=True)
    assert len(plots.window_figure(result, 0).axes) == len(day.axes) + 1  # the yaw


def test_figures_without_attitude() -> None:
    from studies.flight_logs import plots

    log = made(start_utc_s=MORNING_S, duration_h=2.0, rate_hz=0.2)
    result = without(log, *ATTITUDE, "mppt_voltage_v")
    ((_, mask),) = day_masks(result.samples)
    assert len(plots.day_figure(result, result.days[0], mask).axes) == 2  # power and residuals


def test_gaps_of_a_log_are_hatched_and_nights_are_not() -> None:
    from studies.flight_logs import plots

    log = made(start_utc_s=MORNING_S, duration_h=6.0, rate_hz=0.2)
    rows = log.table.index
    cut = log_from_table(log.table[(rows < 2000) | (rows > 2720)], "synthetic.csv")
    result = verify(aircraft(), cut, mission())
    ((_, mask),) = day_masks(result.samples)
    axes = plots.day_figure(result, result.days[0], mask).axes[0]
    (gap,) = (patch for patch in axes.patches if patch.get_label() == "no data")
    assert gap.get_width() == pytest.approx(721 / 0.2 / 3600.0, abs=0.01)
    whole = verified(log)
    ((_, mask),) = day_masks(whole.samples)
    names = [p.get_label() for p in plots.day_figure(whole, whole.days[0], mask).axes[0].patches]
    assert "no data" not in names


def test_result_prints_itself_and_reads_its_own_log(log_file: Path) -> None:
    result = verify(aircraft(), log_file, windows=["5.71:5.79"])
    assert result.mission == "rafz-28h"
    text = " ".join(str(result).split())  # the path may be wider than a line
    assert text.startswith(f"atlantiksolar-as2 against {log_file}")
    for part in ("5.71 to 5.79 h (solar time)", "2015-07-01 (UTC)", "battery full", "not in the"):
        assert part in text
    assert repr(result) == f"<Verification: {result.headline()}>"
    frame = result.to_frame()
    assert len(frame) == result.to_dict()["log"]["sunlit_samples"]
    assert frame["fm_w"].to_numpy() == pytest.approx(result.samples.modelled_w["FM"])
    assert result.to_csv().count("\n") == len(frame) + 1
    with pytest.raises(ValueError, match="must be a:b in solar hours"):
        verify(aircraft(), log_file, windows=["9:8"])


@pytest.mark.parametrize("text", ["9:8", "x"])
def test_command_refuses_bad_windows(log_file: Path, text: str) -> None:
    result = run(log_file, "--window", text)
    assert result.exit_code == 2
    assert "must be a:b in solar hours" in " ".join(result.output.split())


def test_command_reports_mistakes_in_the_log(tmp_path: Path) -> None:
    file = tmp_path / "bad.csv"
    file.write_text("time_utc,latitude_deg\n")
    result = run(file)
    assert isinstance(result.exception, InputError)
    assert "bad.csv:1: longitude_deg: required column is missing" in str(result.exception)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--timezone", "Nowhere/Town"], "must be UTC, an offset like +02:00"),
        (["--column", "power=P"], "no such quantity"),
        (["--filter", "nan"], "must be a number of seconds"),
    ],
)
def test_command_refuses_wrong_layouts(log_file: Path, options: list[str], expected: str) -> None:
    result = run(log_file, *options)
    assert result.exit_code == 2
    assert expected in " ".join(result.output.split()).replace("│ ", "")


def test_command_names_mistakes_in_the_map(log_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "map.yaml"
    file.write_text("columns:\n  solar_power_w: P\ntimezone: 25\n")
    result = run(log_file, "--columns", file)
    assert isinstance(result.exception, InputError)
    assert "map.yaml:3:11: timezone" in str(result.exception)


def test_text_fits_80_columns_for_large_and_small_aircraft() -> None:
    log = made(start_utc_s=MORNING_S, duration_h=3.0, rate_hz=0.1, faults=Faults(mppt=(0.5, 2.0)))
    result = verified(log, windows=["5:6"])
    large = replace(
        result.windows[0],
        errors={
            model: ModelErrors(*(1000.0 * value for value in vars(errors).values()))
            for model, errors in result.windows[0].errors.items()
        },
    )
    for one in (result, replace(result, windows=(large,))):
        assert max(len(line) for line in str(one).splitlines()) <= 80


def test_power_that_is_none_is_not_taken_for_nothing_to_compare() -> None:
    errors = ModelErrors(100.0, -80.0, 180.0, 190.0, 300.0)
    told = model_sentence("FM", errors, 400.0)
    assert told.startswith("FM: -80 W are measured on average: no power of modules")
    assert model_sentence("FM", None, 400.0) == "FM: nothing to compare, no sample counts"


def test_a_log_in_the_folder_of_results_is_not_overwritten(tmp_path: Path) -> None:
    log = tmp_path / "samples.csv"
    log.write_text("a flight that is not flown again")
    done = CliRunner().invoke(
        cli, ["verify", "atlantiksolar-as2", str(log), "--out", str(tmp_path)]
    )
    assert done.exit_code == 2
    assert "is read by this command" in done.output
    assert log.read_text() == "a flight that is not flown again"
