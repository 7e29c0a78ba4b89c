"""Winds by latitude and month reach whatever used the one wind: limits, paths, cells."""

import numpy as np
import pytest
from wind_tables import winds_file

from missions.files.errors import InputError
from missions.library import load_mission
from missions.mission import Mission, Scenarios
from sizing import size
from sizing.day.light import day_axis_h
from sizing.day.module_power import modelled_power, surroundings_in_flight
from sizing.library import load_aircraft
from sizing.program.cells import size_cells
from studies.maps.study import feasibility_map

# Wind [m/s] by latitude and month at 60 % of the time: an own table near the ground.
WINDS = {(40, 6): 2.0, (40, 7): 4.0, (50, 6): 6.0, (50, 7): 10.5}


@pytest.fixture
def windy(tmp_path):
    path = winds_file(
        tmp_path,
        lambda latitude, altitude, month, percentile: WINDS[latitude, month],
        latitudes=(40, 50),
        altitudes_m=(0, 1000),
        months=(6, 7),
        percentiles=(60,),
    )
    data = load_mission("central-europe-summer").model_dump(by_alias=True, exclude_unset=True)
    data |= {
        "latitude_deg": {"from_deg": 40.0, "to_deg": 50.0, "count": 2},
        "dates": {"from": "06-15", "to": "07-15", "count": 2},
        "wind": {"percentile": 60.0, "file": path},
        "flight_path": {"kind": "circle", "radius_m": 200.0, "airspeed_m_per_s": 12.0},
    }
    return Mission.model_validate(data)


def test_a_design_is_faster_than_the_strongest_wind(windy):
    aircraft = load_aircraft("atlantiksolar-design")
    design = size(aircraft, windy).design
    windless = size(aircraft, windy.in_wind(10.5)).design
    calm = size(aircraft, windy.in_wind(0.0)).design
    assert design.airspeed_m_per_s == windless.airspeed_m_per_s
    assert float(design.airspeed_m_per_s) >= 10.5 * (1.0 - 1e-6)
    assert float(calm.airspeed_m_per_s) < 10.5


def test_cells_have_the_wind_of_their_own_latitude_and_month(windy):
    aircraft = load_aircraft("atlantiksolar-design")
    cells = Scenarios(np.array([40.0, 50.0, 50.0]), np.array([166, 166, 196]))
    cells_result = size_cells(aircraft, windy, cells)
    winds = np.array([2.0, 6.0, 10.5])
    assert windy.scenario_winds_m_per_s(cells) == pytest.approx(winds)
    for i, wind in enumerate(winds.tolist()):
        single = Scenarios(cells.latitude_deg[i : i + 1], cells.day_of_year[i : i + 1])
        alone = size_cells(aircraft, windy.in_wind(wind), single)
        # Within the tolerance of the search: cells start from their neighbours.
        expected = pytest.approx(float(alone.variables.wingspan_m[0]), rel=5e-3)
        assert float(cells_result.variables.wingspan_m[i]) == expected
    assert np.all(cells_result.airspeed_m_per_s >= winds * (1.0 - 1e-6))


def test_a_path_is_flown_in_the_wind_of_each_scenario(windy):
    aircraft, noon = load_aircraft("atlantiksolar-as2"), day_axis_h(1.0)
    scenarios = windy.scenarios()
    around = surroundings_in_flight(aircraft, windy)
    together = modelled_power(aircraft, windy, "FM", scenarios, noon, around)
    for i, wind in enumerate(windy.scenario_winds_m_per_s().tolist()):
        single = Scenarios(scenarios.latitude_deg[i : i + 1], scenarios.day_of_year[i : i + 1])
        alone = modelled_power(aircraft, windy.in_wind(wind), "FM", single, noon, around)
        assert np.array_equal(together[i], alone[0])


def test_a_map_has_no_wind_where_the_table_ends(windy):
    aircraft = load_aircraft("atlantiksolar-as2")
    data = feasibility_map(aircraft, windy, latitudes=[39.0, 40.0], days=[100, 166])
    assert np.isnan(data["wind"].to_numpy()).tolist() == [[True, True], [True, False]]
    assert "failed_cells" not in data.attrs
    with pytest.raises(InputError, match="has latitude_deg 40 to 50"):
        feasibility_map(aircraft, windy, latitudes=[39.0, 40.0], days=[166], model="FM")
