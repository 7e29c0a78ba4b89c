"""``solar-uav station``: time on station by month."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sizing.program.objectives import SizingStatus

DESIGN = "atlantiksolar-design"
GOOD = (
    *("--set", "mission.altitude_m=12000", "--set", "mission.air={}"),
    *("--set", "mission.wind={percentile: 95}", "--set", "modules.efficiency_stc=0.3"),
    *("--set", "battery.specific_energy_wh_per_kg=400"),
)


def test_terminal_json_and_files_say_the_same(run, tmp_path):
    call = ("station", DESIGN, *GOOD, "--latitudes", "30:60:30")
    record = run(*call, "--json", "--out", "a.nc").json()
    share = np.array(record["share_on_station"])
    assert share.shape == (2, 12)
    assert share.max() > 0.5
    outcome = run(*call, "--out", "a.csv", "--plot", "a.png").good()
    assert f"up to {100.0 * share.max():.0f} % of the time" in " ".join(outcome.out.split())
    with xr.open_dataset(tmp_path / "a.nc") as data:
        assert np.array_equal(data["share"].to_numpy(), share)
        assert data["share"].dims == ("latitude", "month")
        assert "mission" in data.attrs
    assert (tmp_path / "a.png").stat().st_size > 5_000
    table = pd.read_csv(tmp_path / "a.csv")
    assert table["share_on_station"].to_numpy() == pytest.approx(share.ravel(), abs=1e-9)


def test_the_altitude_of_the_largest_share_is_flown_in_each_month(run, tmp_path):
    call = ("station", DESIGN, *GOOD, "--latitudes", "45:45:1")
    heights = (9500, 12000)
    records = [run(*call, "--set", f"mission.altitude_m={h}", "--json").json() for h in heights]
    both = (*call, "--altitudes", "9500:12000:2500")
    record = run(*both, "--json", "--out", "c.nc").json()
    shares = np.array([record["share_on_station"] for record in records])
    assert np.array_equal(record["share_on_station"], shares.max(axis=0))
    chosen = np.array(heights)[shares.argmax(axis=0)]
    assert np.array_equal(record["altitude_m"], chosen)
    assert len(set(chosen.ravel().tolist())) == 2  # neither is the best everywhere
    assert "altitude of that share [km]" in run(*both, "--plot", "c.png").out
    with xr.open_dataset(tmp_path / "c.nc") as data:
        assert np.array_equal(data["chosen_altitude"].to_numpy(), chosen)


def test_cells_too_windy_for_the_path_are_infeasible_and_not_failed(run, tmp_path):
    keys = ("altitude_m=20000", "flight_path.airspeed_m_per_s=25", "flight_path.radius_m=600")
    where = [word for key in keys for word in ("--set", f"mission.{key}")]
    where += ["--set", "mission.wind={percentile: 95}", "--model", "VM"]
    cells = ("--latitudes", "20:60:40", "--days", "1:181:180")
    out = str(tmp_path / "m.nc")
    record = run("map", "atlantiksolar-as2", *where, *cells, "--json", "--out", out).json()
    assert record["failed_days"] == [0, 0]
    assert record["too_windy_days"] == [1, 1]
    with xr.open_dataset(out) as data:
        # A wind as fast as the airspeed is too fast; the calm cell is flown as alone.
        names = data["status"].attrs["flag_meanings"].split()
        values = dict(zip(names, np.atleast_1d(data["status"].attrs["flag_values"]), strict=True))
        gone = data["status"].to_numpy() == values["infeasible"]
        assert np.array_equal(gone, data["wind"].to_numpy() >= 25.0)
        assert np.array_equal(gone, np.isnan(data["excess_time"].to_numpy()))
        alone = float(data["excess_time"].sel(latitude=60.0, day=181))
    there = ("--set", "mission.latitude_deg=60", "--set", "mission.dates.on=06-30")
    flown = run("analyse", "atlantiksolar-as2", *where, *there, "--json").json()
    assert alone == pytest.approx(flown["excess_time_h"], abs=1e-6)
    shown = run("map", "atlantiksolar-as2", *where, *cells)
    assert "too windy for the path" in shown.out
    run("map", "atlantiksolar-as2", *where, "--latitudes", "60:70:10", "--days", "1:31:30").good()
    # The mission's own place is none of the cells, however windy it is.
    windy = [*where, "--set", "mission.latitude_deg=60", "--set", "mission.dates.on=01-01"]
    assert run("analyse", "atlantiksolar-as2", *windy).code == 2
    from_there = run("map", "atlantiksolar-as2", *windy, *cells, "--json").json()
    assert from_there["too_windy_days"] == [1, 1]


def test_cells_of_designs_too_windy_for_the_path_say_so(run, tmp_path):
    winds = tmp_path / "winds.csv"
    rows = [
        f"{x},{z},{m},95,{12 if m == 6 and x > 30 else 3}"
        for x in (-90, 30, 40, 90)
        for z in (0, 2000)
        for m in range(1, 13)
    ]
    winds.write_text("\n".join(["latitude_deg,altitude_m,month,percentile,wind_m_per_s", *rows]))
    where = ["--set", f"mission.wind={{percentile: 95, file: {winds}}}", "--model", "VM"]
    where += ["--set", "mission.flight_path.airspeed_m_per_s=8.6"]
    sized = ("map", DESIGN, "--resize", "min_mass", *where, "--latitudes", "30:40:10")
    out = tmp_path / "m.nc"
    shown = run(*sized, "--days", "152:182:30", "--out", str(out)).good()
    assert "too windy for the path" in shown.out
    assert "failed" not in shown.out + shown.err
    with xr.open_dataset(out) as data:
        windy = (data["status"] == int(SizingStatus.infeasible)).to_numpy()
        assert windy.tolist() == [[False, False], [True, False]]  # 40 N on 1 June
        message = str(data["message"].to_numpy()[1, 0])
        assert message.startswith("flight path: the wind of 12 m/s is not below the airspeed")
        assert str(data["violated_requirement"].to_numpy()[1, 0]) == "flight_path"
        # 12 over 8.6 m/s.
        assert float(data["shortfall"][1, 0]) == pytest.approx(12.0 / 8.6 - 1.0)
        mass = float(data["total_mass"][1, 1])
    alone = run(*sized, "--days", "182:182:1", "--json").json()
    assert alone["least_total_mass_kg"][1] == pytest.approx(mass, rel=1e-3)
    assert "too_windy_days" not in alone
    # Nothing but windy cells is a result as well.
    every = run(*sized[:-2], "--latitudes", "40:50:10", "--days", "152:153:1", "--json").good()
    assert every.json()["too_windy_days"] == [2, 2]
    assert every.json()["failed_days"] == [0, 0]
