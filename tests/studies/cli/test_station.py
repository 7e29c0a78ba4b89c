"""``solar-uav station``: time on station by month."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from command_line import Run

DESIGN = "atlantiksolar-design"
GOOD = (
    *("--set", "mission.altitude_m=12000", "--set", "mission.air={}"),
    *("--set", "mission.wind={percentile: 95}", "--set", "modules.efficiency_stc=0.3"),
    *("--set", "battery.specific_energy_wh_per_kg=400"),
)


def test_terminal_json_and_files_say_the_same(run: Run, tmp_path: Path) -> None:
    latitudes = ("--latitudes", "30:60:15")
    record = run("station", DESIGN, *GOOD, *latitudes, "--json").json()
    share = np.array(record["share_on_station"])
    assert share.shape == (3, 12)
    assert share.max() > 0.5
    outcome = run(
        *("station", DESIGN, *GOOD, *latitudes, "--out", str(tmp_path / "a.nc")),
        *("--plot", str(tmp_path / "a.png")),
    )
    assert outcome.code == 0
    assert f"up to {100.0 * share.max():.0f} % of the time" in " ".join(outcome.out.split())
    with xr.open_dataset(tmp_path / "a.nc") as data:
        assert np.array_equal(data["share"].to_numpy(), share)
        assert data["share"].dims == ("latitude", "month")
        assert "mission" in data.attrs
    assert (tmp_path / "a.png").stat().st_size > 5_000
    run("station", DESIGN, *GOOD, *latitudes, "--out", str(tmp_path / "a.csv"))
    table = pd.read_csv(tmp_path / "a.csv")
    assert table["share_on_station"].to_numpy() == pytest.approx(share.ravel(), abs=1e-9)


def test_altitudes_go_in_place_of_latitudes(run: Run, tmp_path: Path) -> None:
    altitudes = ("--altitudes", "10000:14000:2000")
    record = run("station", DESIGN, *GOOD, *altitudes, "--json").json()
    assert record["altitudes_m"] == [10000.0, 12000.0, 14000.0]
    plot = str(tmp_path / "b.png")
    assert run("station", DESIGN, *GOOD, *altitudes, "--plot", plot).code == 0


def test_the_altitude_of_the_largest_share_is_flown_in_each_month(run: Run, tmp_path: Path) -> None:
    here = ("--latitudes", "40:50:10")
    heights = (9500, 12000)
    each = [
        run("station", DESIGN, *GOOD, *here, "--set", f"mission.altitude_m={h}", "--json").json()
        for h in heights
    ]
    both = ("station", DESIGN, *GOOD, *here, "--altitudes", "9500:12000:2500")
    record = run(*both, "--json").json()
    shares = np.array([one["share_on_station"] for one in each])
    assert np.array_equal(record["share_on_station"], shares.max(axis=0))
    chosen = np.array(heights)[shares.argmax(axis=0)]
    assert np.array_equal(record["altitude_m"], chosen)
    assert len(set(chosen.ravel().tolist())) == 2  # neither is the best everywhere
    outcome = run(*both, "--out", str(tmp_path / "c.nc"), "--plot", str(tmp_path / "c.png"))
    assert "altitude of that share [km]" in outcome.out
    with xr.open_dataset(tmp_path / "c.nc") as data:
        assert np.array_equal(data["chosen_altitude"].to_numpy(), chosen)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("atlantiksolar-as2",), "station needs a parametric aircraft"),
        ((DESIGN,), "rafz-july: lacks wind: {percentile: ...}"),
        ((DESIGN, *GOOD, "--latitudes", "80:90:5"), "has latitude_deg -88 to 88 (got 90)"),
        ((DESIGN, *GOOD, "--altitudes", "0:8000:4000"), "has altitude_m 9126 to 33043 (got 0)"),
        ((DESIGN, "--set", "mission.wind.percentile=95"), "has altitude_m 9126 to 33043 (got 536)"),
    ],
)
def test_what_has_no_answer_is_refused_in_a_line(
    run: Run, arguments: tuple[str, ...], message: str
) -> None:
    outcome = run("station", *arguments)
    assert outcome.code == 2
    assert message in outcome.err
    assert len(outcome.err.splitlines()) == 1
    assert not outcome.out


HOLDING = (*GOOD, "--set", "mission.wind.hold_station=true", "--set", "mission.dates.on=07-01")


def test_studies_of_an_aircraft_that_holds_its_place_fly_as_its_analysis(
    run: Run, tmp_path: Path
) -> None:
    analysed = run("analyse", DESIGN, *HOLDING, "--json").json()
    drawn = run("uncertainty", DESIGN, *HOLDING, "--samples", "64", "--json").json()
    assert drawn["nominal_excess_time_h"] == pytest.approx(analysed["excess_time_h"], abs=1e-9)
    page = tmp_path / "r.html"
    assert run("report", DESIGN, *HOLDING, "--out", str(page)).code == 0
    text = page.read_text(encoding="utf-8")
    assert "flown, to hold its place" in text
    assert f"{analysed['excess_time_h']:.2f} h" in text.replace("−", "-")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("explore", "--static", "page.html"), "one power of level flight for all places and days"),
        (("map", "--latitudes", "80:90:5", "--days", "1:365:91"), "latitude_deg -88 to 88 (got"),
    ],
)
def test_where_a_held_place_has_no_answer_it_is_refused_in_a_line(
    run: Run, arguments: tuple[str, ...], message: str
) -> None:
    command, *options = arguments
    outcome = run(command, DESIGN, *HOLDING, *options)
    assert outcome.code == 2
    assert message in outcome.err
    assert len(outcome.err.splitlines()) == 1


def test_a_map_that_needs_the_wind_is_refused_where_no_table_knows_it(run: Run) -> None:
    cells = ("--latitudes", "80:90:5", "--days", "1:365:91")
    sized = run("map", DESIGN, *GOOD, *cells, "--resize", "min_wingspan")
    assert sized.code == 2
    assert sized.err.splitlines() == ["the shipped table: has latitude_deg -88 to 88 (got 90)"]
