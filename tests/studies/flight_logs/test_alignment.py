"""Clock, heading and unit of logs that lie by a known amount."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from log_layouts import LAYOUTS, OWN_NAMES_MAP, dataflash_of

from benchmarks.log_offsets import lying, random_days
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.logs.columns import ColumnMap, read_column_map
from missions.logs.csv import read_flight_log
from missions.logs.table import EulerAngles, FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from solar.geometry import ModuleGeometry
from studies.flight_logs.alignment.offsets import Alignment, Offset, align
from studies.flight_logs.alignment.shifted_power import ShiftedPower
from studies.flight_logs.samples import lit_samples
from studies.flight_logs.synthetic import Faults, Settings, synthetic_log
from studies.flight_logs.verification import verify

pytestmark = pytest.mark.slow


@cache
def aircraft() -> Aircraft:
    return load_aircraft("atlantiksolar-as2")


@cache
def mission() -> Mission:
    return load_mission("rafz-28h")


def geometry() -> ModuleGeometry:
    found = aircraft().modules.geometry
    assert found is not None
    return found


@cache
def flown(faults: Faults | None = None, rate_hz: float = 0.05) -> FlightLog:
    settings = Settings(rate_hz=rate_hz, faults=faults or Faults())
    return synthetic_log(aircraft(), mission(), settings).log()


def check(found: Alignment, ahead_s: float, turned_deg: float) -> None:
    """Recovered within 2 min and 3 deg."""
    assert found.clock_ahead_s is not None
    assert found.heading_ahead_deg is not None
    assert found.clock_ahead_s.value == pytest.approx(ahead_s, abs=120.0)
    turn = found.heading_ahead_deg.value - turned_deg
    assert (turn + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=3.0)


@pytest.mark.parametrize(
    ("ahead_s", "turned_deg", "factor", "unit"),
    [
        (7200.0, 0.0, 1.0, "W"),
        (0.0, 90.0, 1.0, "W"),
        (-19800.0, -40.0, 1e-3, "kW"),
        (11 * 3600.0, 180.0, 1e3, "mW"),
        (420.0, 12.0, 1.0, "W"),
    ],
)
def test_injected_errors_are_recovered(
    ahead_s: float, turned_deg: float, factor: float, unit: str
) -> None:
    log = lying(flown(), ahead_s=ahead_s, turned_deg=turned_deg, factor=factor)
    found = align(log, aircraft(), mission(), geometry())
    check(found, ahead_s, turned_deg)
    assert found.power_unit == unit
    assert found.level == pytest.approx(1.0, abs=0.01)
    # Below three standard deviations nothing is said, and 2 % of drift is 2 min on this flight.
    assert found.clock_wrong == (abs(ahead_s) > 360.0)
    assert found.heading_wrong == (turned_deg != 0.0)
    corrected = found.corrected(log)
    assert corrected.time_s == pytest.approx(flown().time_s, abs=120.0)
    assert corrected.solar_power_w == pytest.approx(flown().solar_power_w)


@pytest.mark.parametrize(
    "faults",
    [
        Faults(battery_full=(24.0, 27.0)),
        Faults(mppt=(18.5, 21.0), missing=(3.0, 9.0)),
        Faults(side_bias=("right", 0.1)),
    ],
)
def test_faults_of_the_aircraft_are_no_errors_of_the_log(faults: Faults) -> None:
    honest = align(flown(faults), aircraft(), mission(), geometry())
    assert not honest.wrong
    check(honest, 0.0, 0.0)
    log = lying(flown(faults), ahead_s=-3600.0, turned_deg=-40.0)
    check(align(log, aircraft(), mission(), geometry()), -3600.0, -40.0)


def clouded(log: FlightLog, cover: float) -> FlightLog:
    """Clouds of ten minutes each, that leave a tenth to seven tenths of the power."""
    rng = np.random.default_rng(3)
    count = int((log.time_s[-1] - log.time_s[0]) / 600.0) + 1
    left = np.where(rng.random(count) < cover, rng.uniform(0.1, 0.7, count), 1.0)
    number = ((log.time_s - log.time_s[0]) / 600.0).astype(int)
    return replace(log, solar_power_w=left[number] * log.solar_power_w)


def test_clouds_do_not_move_the_estimate() -> None:
    log = lying(clouded(flown(), 0.4), ahead_s=7200.0, turned_deg=45.0)
    check(align(log, aircraft(), mission(), geometry()), 7200.0, 45.0)


def test_under_an_overcast_sky_there_is_no_number() -> None:
    found = align(clouded(flown(), 0.8), aircraft(), mission(), geometry())
    assert found.clock_ahead_s is None
    assert found.heading_ahead_deg is None
    assert not found.wrong
    assert "not checked" in found.notes[0]


def level_flight() -> tuple[FlightLog, ModuleGeometry]:
    """Flight with the wing level, of modules that lie flat."""
    flat = [
        s.model_copy(update={"dihedral_deg": 0.0, "pitch_deg": 0.0}) for s in geometry().surfaces
    ]
    modules = geometry().model_copy(update={"wing_incidence_deg": 0.0, "surfaces": tuple(flat)})
    log = flown()
    assert log.attitude is not None
    zero = np.zeros(len(log))
    log = replace(log, attitude=EulerAngles(zero, zero, log.attitude.yaw_rad))
    every = np.arange(len(log))
    power = ShiftedPower.of(log, aircraft(), mission(), modules, every).power_w(0.0)
    noise = np.random.default_rng(0).normal(0.0, 1.0, len(log))
    return replace(log, solar_power_w=power + noise), modules


def test_level_wing_says_nothing_of_the_heading() -> None:
    log, flat = level_flight()
    found = align(lying(log, ahead_s=3600.0, turned_deg=90.0), aircraft(), mission(), flat)
    assert found.heading_ahead_deg is None
    assert not found.heading_wrong
    assert found.clock_ahead_s is not None
    assert found.clock_ahead_s.value == pytest.approx(3600.0, abs=120.0)
    assert any("level wing" in note for note in found.notes)


def test_log_without_attitude_tells_a_time_zone_but_no_heading() -> None:
    bare = replace(lying(flown(), 3600.0, 0.0), attitude=None)
    found = align(bare, aircraft(), mission())
    assert found.heading_ahead_deg is None
    assert found.clock_wrong
    assert found.clock_ahead_s is not None
    # CAM does not know how the wind tilts the wing: a few hundred seconds, as it says itself.
    assert abs(found.clock_ahead_s.value - 3600.0) < 3.0 * found.clock_ahead_s.sigma
    assert found.clock_correction_s == 3600.0


def test_correction_is_a_time_zone_where_that_is_as_likely() -> None:
    def correction(value: float, sigma: float) -> float:
        return Alignment(clock_ahead_s=Offset(value, sigma), clock_wrong=True).clock_correction_s

    assert correction(7230.0, 20.0) == 7200.0
    assert correction(-19700.0, 100.0) == -19800.0
    assert correction(900.0, 100.0) == 900.0


@pytest.mark.filterwarnings("ignore")  # places where the air is outside of a model's range
def test_random_clear_days_are_sound_and_lies_on_them_are_found() -> None:
    for where, settings in random_days(4):
        log = synthetic_log(aircraft(), where, settings).log()
        flight = with_values(mission(), {"latitude_deg": float(np.mean(where.latitudes()))})
        sound = verify(aircraft(), log, flight)
        assert sound.anomalies == ()
        assert not sound.corrected
        false = lying(log, ahead_s=-5 * 3600.0, turned_deg=60.0)
        check(align(false, aircraft(), flight, geometry()), -5 * 3600.0, 60.0)


# How a log is written, how far its clock is ahead [s] and its heading clockwise [deg], its rate.
LIES = {
    "ground_station": (-19800.0, 35.0, 0.1),
    "spreadsheet": (7200.0, -90.0, 0.02),
    "telemetry": (1500.0, 180.0, 0.2),
    "own_names": (3600.0, 15.0, 0.05),
    "dataflash": (-900.0, -45.0, 0.1),
}


@pytest.mark.parametrize("name", LIES)
def test_every_layout_tells_its_lies(name: str, tmp_path: Path) -> None:
    """Five layouts that differ in columns, units, zone and rate, each with a wrong clock."""
    ahead_s, turned_deg, rate_hz = LIES[name]
    rows = synthetic_log(aircraft(), mission(), Settings(rate_hz=rate_hz)).table
    late = pd.to_datetime(rows["time_utc"], utc=True) + pd.Timedelta(seconds=ahead_s)
    rows["time_utc"] = late.dt.strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    rows["yaw_deg"] = (rows["yaw_deg"] + turned_deg + 180.0) % 360.0 - 180.0
    layout = ColumnMap()
    if name == "spreadsheet":
        layout = layout.with_options({}, "Europe/Zurich")
    elif name == "own_names":
        (tmp_path / "map.yaml").write_text(OWN_NAMES_MAP)
        layout = read_column_map(str(tmp_path / "map.yaml"))
    elif name == "dataflash":
        power = {"solar_power_w": "BAT[1].Volt * BAT[1].Curr"}
        layout = layout.with_options(power, None)
    file = tmp_path / ("log.bin" if name == "dataflash" else "log.csv")
    content = LAYOUTS[name](rows).encode() if name in LAYOUTS else dataflash_of(rows)
    file.write_bytes(content)
    log = read_flight_log(file, layout)
    check(align(log, aircraft(), mission(), geometry()), ahead_s, turned_deg)


def test_power_at_no_offset_is_that_of_the_full_model() -> None:
    log = flown()
    samples, _ = lit_samples(log, aircraft(), mission(), geometry(), None)
    power = ShiftedPower.of(log, aircraft(), mission(), geometry(), samples.index).power_w(0.0)
    assert power == pytest.approx(samples.modelled_w["FM"], rel=1e-9)
    # A logged heading that is too far clockwise is the same as a sun too far counterclockwise.
    turned = lying(log, 0.0, 30.0)
    other = ShiftedPower.of(turned, aircraft(), mission(), geometry(), samples.index)
    assert other.power_w(0.0, np.radians(30.0)) == pytest.approx(power, rel=1e-9)
    late = ShiftedPower.of(lying(log, 600.0, 0.0), aircraft(), mission(), geometry(), samples.index)
    assert late.power_w(600.0) == pytest.approx(power, rel=1e-9)


def test_lies_are_told_and_nothing_else_is_blamed() -> None:
    log = lying(flown(), ahead_s=7200.0, turned_deg=90.0, factor=1e-3)
    found = verify(aircraft(), log, mission())
    assert found.anomalies == ()
    text = " ".join(str(found).split())
    for told in (
        "the power is in kW, not W; compared as corrected",
        "ahead of universal time, as a clock of UTC+02:00 is; compared as corrected",
        "heading of the log: off by +90.0 +- ",
        "FM agrees with the flight",
    ):
        assert told in text
    record = found.to_dict()["alignment"]
    assert record["power_unit"] == "kW"
    assert record["clock_wrong"]
    assert record["corrected"]
    as_logged = verify(aircraft(), lying(flown(), 0.0, 90.0), mission(), correct=False)
    assert "compared as logged" in " ".join(str(as_logged).split())
    assert not as_logged.corrected


def test_too_little_power_is_not_judged() -> None:
    dark = replace(flown(), solar_power_w=np.zeros(len(flown())))
    assert not align(dark, aircraft(), mission(), geometry()).wrong
