"""Studies of missions with climbs: every result beside the analysis of the same flight."""

import numpy as np
import pytest

from missions.dates import date_code
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.mission import Mission
from missions.uncertainty import Normal
from sizing.ceiling import flight_at_altitude, highest_perpetual_altitude
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.library import load_aircraft
from sizing.performance import performance
from sizing.results.analysis import analyse
from sizing.uncertainty.inputs import UncertainInput, UncertainInputs
from sizing.uncertainty.propagation import check_inputs, propagation_of
from studies.ceiling import perpetual_ceiling
from studies.maps.results import MapResult
from studies.maps.study import feasibility_map
from studies.sweeps.results import SweepResult
from studies.sweeps.study import sweep

AS2, DESIGN = load_aircraft("atlantiksolar-as2"), load_aircraft("atlantiksolar-design")
# The same program everywhere; what it starts from differs in last digits.
STEP_H = 3e-3


def mission(ceiling_m=3536.0, **changes):
    climb = {"ceiling_m": ceiling_m}
    data = {"launch": None, "air": {}, "dates": {"on": "06-21"}, "climb": climb} | changes
    return load_mission("rafz-july", data)


def analysed(aircraft, flown, **options):
    return analyse(aircraft, flown, replay=False, **options)


@pytest.mark.parametrize("model", ["CAM", "VM"])
def test_cell_of_a_map_is_the_analysis_of_its_day(model):
    flown = mission(2536.0)
    data = feasibility_map(AS2, flown, latitudes=[20.0, 55.0], days=[80, 172], model=model)
    for latitude, day in ((20.0, 172), (55.0, 80)):
        cell = data.sel(latitude=latitude, day=day)
        place = {"latitude_deg": latitude, "dates": {"on": date_code(day)}}
        alone = analysed(AS2, with_values(flown, place), model=model)
        assert float(cell["excess_time"]) == pytest.approx(alone.excess_time_h, abs=STEP_H)
        assert float(cell["maximum_altitude"]) == pytest.approx(
            alone.climb.altitude_m[0].max(),
            abs=4.0,  # of 400 m of climb, in steps of five minutes and of one
        )
    assert data.attrs["climb"] == "climbs from 536 to 2536 m"


def test_map_tells_its_climbs_and_what_they_leave_out():
    data = feasibility_map(AS2, mission(), latitudes=[40.0, 47.6], days=[172], endurance=True)
    assert "climbs from 536 to 3536 m" in str(MapResult(data))
    assert "module_temperature" in data.attrs["extrapolations"]
    assert np.all(np.isposinf(data["endurance"].to_numpy()))


def test_point_of_a_trade_study_is_the_analysis_of_its_files():
    ceilings_m = [536.0, 2000.0, 5000.0]
    data = sweep(AS2, mission(), {"mission.climb.ceiling_m": ceilings_m})
    for ceiling_m, excess_h, highest_m in zip(
        ceilings_m, data["excess_time"].to_numpy(), data["maximum_altitude"].to_numpy(), strict=True
    ):
        alone = analysed(AS2, mission(ceiling_m))
        assert excess_h == pytest.approx(alone.excess_time_h, abs=STEP_H)
        assert highest_m == pytest.approx(ceiling_m, abs=1.0)
    assert SweepResult(data).to_dict()["climb"] == "with climbs"


def test_floor_of_a_file_can_be_varied():
    flown = mission(altitude_m=1000.0)
    named = flown.model_dump(by_alias=True, exclude_unset=True)
    named["climb"]["minimum_altitude_m"] = named.pop("altitude_m")
    data = sweep(
        AS2, Mission.model_validate(named), {"mission.climb.minimum_altitude_m": [1e3, 2e3]}
    )
    for floor_m, excess_h in zip([1e3, 2e3], data["excess_time"].to_numpy(), strict=True):
        alone = analysed(AS2, mission(altitude_m=floor_m))
        assert excess_h == pytest.approx(alone.excess_time_h, abs=STEP_H)


@pytest.mark.slow
def test_highest_floor_is_where_climbs_end_perpetual_flight():
    flown = mission(14000.0)
    found = highest_perpetual_altitude(AS2, flown, step_m=4000.0)
    edge_m = found.highest.altitude_m
    below, above = (
        analysed(AS2, flown.climbing_from(edge_m + shift_m)).excess_time_h
        for shift_m in (-5.0, 5.0)
    )
    assert below > -STEP_H
    assert above < STEP_H
    assert below > above
    # Height carries through a part of the night that the battery alone does not.
    level = highest_perpetual_altitude(AS2, flown.at_altitude(536.0), step_m=4000.0)
    assert edge_m > level.highest.altitude_m
    assert found.flights[-1].altitude_m == 14000.0
    same = flight_at_altitude(AS2, flown, UNCORRECTED_CAM, 14000.0)
    flat = flight_at_altitude(AS2, flown.at_altitude(536.0), UNCORRECTED_CAM, 14000.0)
    assert same.excess_time_h == pytest.approx(flat.excess_time_h, abs=STEP_H)


def test_search_for_the_floor_ends_at_the_ceiling_and_says_so():
    result = perpetual_ceiling(AS2, mission(2000.0), step_m=1000.0)
    text = " ".join(str(result).split())
    assert "with climbs to 2000 m from night floors up to 2000 m, the ceiling itself" in text
    floors_m = [row[0] for row in result.table().rows]
    assert floors_m == [536.0, 1000.0, 2000.0]
    record = result.to_dict()
    assert record["climb"] == {"ceiling_m": 2000.0}
    # Heights come from interior points: a hair below the ceiling.
    heights_m = [row["maximum_altitude_m"] for row in record["altitudes"]]
    assert heights_m == pytest.approx([2000.0] * len(heights_m), abs=0.01)
    with pytest.raises(ValueError, match="must be above the mission's altitude"):
        perpetual_ceiling(AS2, mission(536.0))


CASES = [
    (DESIGN, {"modules.camber_efficiency": 0.9, "modules.diffuse_efficiency": 0.7}),
    (DESIGN, {"battery.specific_energy_wh_per_kg": 220.0, "airframe.structure.calibration": 1.4}),
    (AS2, {"mission.turbulence.all_day": 0.2, "mission.turbulence.thermal": 0.3}),
    (AS2, {"mission.air.temperature_offset_k": 8.0, "battery.charge_efficiency": 0.9}),
    (AS2, {"mission.clearness": 0.7, "mission.payload.mass_kg": 0.2}),
]


@pytest.mark.parametrize(
    ("aircraft", "changes"),
    [*CASES[:1], *(pytest.param(*case, marks=pytest.mark.long) for case in CASES[1:-1]), CASES[-1]],
)
def test_draw_is_what_it_is_alone(aircraft, changes):
    flown = mission(
        latitude_deg={"from_deg": 30.0, "to_deg": 50.0, "count": 2},
        air={"temperature_offset_k": 0.0},
        turbulence={"all_day": 0.05, "thermal": 0.1},
    )
    values = {key: np.array([value, value]) for key, value in changes.items()}
    found = propagation_of(aircraft, flown, SolarModel()).flights(values)
    of = {True: {}, False: {}}
    for key, value in changes.items():
        of[key.startswith("mission.")][key.removeprefix("mission.")] = value
    alone = performance(with_values(aircraft, of[False]), with_values(flown, of[True]))
    # It flies a profile of the file's values in about such light, to which programs agree as well.
    assert found.excess_time_h[-1] == pytest.approx(alone.cycle.excess_time_h.min(), abs=0.02)
    assert found.maximum_altitude_m[-1] == pytest.approx(alone.maximum_altitude_m.max(), abs=0.1)


def test_heights_of_climbs_do_not_scatter():
    one = UncertainInput("mission.climb.ceiling_m", 3536.0, Normal(sigma=10.0))
    with pytest.raises(ValueError, match="vary it with `sweep`"):
        check_inputs(UncertainInputs((one,), np.eye(1)), mission(), SolarModel())
