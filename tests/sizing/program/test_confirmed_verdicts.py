"""Optima that a finer time step confirms, payloads of grams, and verdicts that are plain."""

from dataclasses import replace

import builders
import numpy as np
import pytest

from missions.mission import Scenarios
from sizing.day.light import SolarModel, solar_day
from sizing.performance import performance
from sizing.program.cells import size_cells
from sizing.program.cross_check import cross_check
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft

pytestmark = pytest.mark.slow

# A battery that is warm at no cost, and modules as cold as the air: as near the ground.
WARM = "battery.temperature={held_c: 25, heat_loss_w_per_k: 0.000001}"
# A heavy structure at 8 km: the payload is a fiftieth of the mass.
HEAVY = builders.aircraft(
    "sky-sailor",
    WARM,
    "airframe.structure={model: power_law_all, coefficient_kg: 0.14200525731361266, "
    "span_exponent: 2.5462921681818944, aspect_ratio_exponent: -0.5120003039542694}",
    "airframe.aerodynamics={model: wing_polar, airfoil: sd7037, design_aspect_ratio: 13.2, "
    "design_reynolds: 120700.26740626043}",
    "airframe.avionics_mass_kg=0",
    "modules.efficiency_stc=0.273371014574237",
    "battery.specific_energy_wh_per_kg=364.16252626394237",
    "battery.charge_limit={kind: rule, c_rate_per_h: 0.4104685501042074, "
    "taper_start: 0.21666745401140564, relative_rate_at_full: 0.2563034486614849}",
    "power={avionics_w: 6, supply_efficiency: 1}",
    "design_space={wingspan_m: {minimum: 1, maximum: 11}, "
    "battery_mass_kg: {minimum: 0.3, maximum: 22}, "
    "module_area_m2: {minimum: 0.01, maximum: 15.125}}",
)
HIGH = builders.mission(
    latitude_deg={"from_deg": -2.402233674540703, "to_deg": 17.390815197845132, "count": 3},
    dates={"from": "12-19", "to": "01-18"},
    altitude_m=8130.6177171614645,
    air={"module_temperature_c": -37.78},
    clearness=0.7186088060060842,
    turbulence={"thermal": 0.3},
    uncertainty_margins={"battery_capacity": 0.8},
)
CDM = SolarModel("CDM", "report")
NARROW = builders.aircraft(
    "atlantiksolar-design",
    WARM,
    "airframe.structure={model: spar, calibration: 0.530477767102663, "
    "safety_factor: 1.9396134321440504, minimum_moment_fraction: 0.5749577317027619}",
    "airframe.aerodynamics={lift_coefficient: 0.6752011557645274, maximum_lift_coefficient: 1.4, "
    "profile_drag_coefficient: 0.014294079272960112, reference_reynolds: 158000, "
    "reynolds_exponent: 0.5, parasitic_drag_coefficient: 0.008, span_efficiency: 0.92}",
    "airframe.propulsion.climb_power_ratio=null",
    "airframe.propulsion.climb_rate_m_per_s=2.425291549313364",
    "airframe.avionics_mass_kg=0.3",
    "modules.efficiency_stc=0.2886502813609668",
    "battery.specific_energy_wh_per_kg=629.0456833154007",
    "battery.charge_limit={kind: rule, c_rate_per_h: 0.13301696619514558, "
    "taper_start: 0.2453252327807131, relative_rate_at_full: 0.3451914360329007}",
    "battery.ageing={seasons_flown: 0.5}",
    "power={avionics_w: 6, supply_efficiency: 0.9}",
    "design_space={wingspan_m: {minimum: 1, maximum: 28}, "
    "battery_mass_kg: {minimum: 0.3, maximum: 140}, module_area_m2: {minimum: 0.01, maximum: 98}, "
    "aspect_ratio: {minimum: 15, maximum: 20}, "
    "limits: {wing_loading_kg_per_m2: {maximum: 4.43528777859307}, "
    "load_w: {maximum: 191.47671518744886}}}",
)


@pytest.mark.parametrize("objective", [Objective.min_mass, Objective.max_payload_mass])
def test_optimum_keeps_its_requirement_with_steps_of_a_minute(objective):
    best = size_aircraft(HEAVY, HIGH, objective, CDM, required_excess_time_h=2.0)
    assert best.design is not None
    day = solar_day(HEAVY, HIGH, CDM, step_h=1.0 / 60.0)
    fine = performance(HEAVY, HIGH, CDM, day=day, design=best.design)
    # The simulator's steps of five minutes make 0.0015 h.
    assert np.min(fine.cycle.excess_time_h) >= 2.0 - 0.003


def test_payload_of_grams_is_the_largest_to_a_part_of_itself():
    best = size_aircraft(HEAVY, HIGH, Objective.max_payload_mass, CDM, required_excess_time_h=2.0)
    # A search by simulation alone has a feasible design with 0.2251 kg of 11 kg.
    assert best.objective_value > 0.2251
    assert cross_check(HEAVY, HIGH, best, CDM).cross_checked
    # What is the best for a minute more is not the best for what is required.
    more = size_aircraft(HEAVY, HIGH, Objective.max_payload_mass, CDM, required_excess_time_h=2.017)
    lost_kg = best.objective_value - more.objective_value
    assert 0.01 * best.objective_value < lost_kg < 1e-3 * more.design.total_mass_kg


@pytest.mark.xfail(
    reason="the payload is 3 % below the optimum; the best of 400 random neighbours has 0.2 % "
    "more, less than the 0.5 % that a cross-check tolerates",
    strict=True,
)
def test_payload_that_is_short_by_grams_is_not_cross_checked():
    more = size_aircraft(HEAVY, HIGH, Objective.max_payload_mass, CDM, required_excess_time_h=2.017)
    claimed = replace(more, required_excess_time_h=2.0)
    assert not cross_check(HEAVY, HIGH, claimed, CDM).cross_checked


@pytest.mark.parametrize(
    ("share", "status"), [(0.995, SizingStatus.optimal), (1.005, SizingStatus.infeasible)]
)
def test_verdict_next_to_the_largest_payload(share, status):
    place = builders.mission(
        latitude_deg={"from_deg": -61.25783210261999, "to_deg": -46.88770106591673, "count": 3},
        dates={"on": "11-27"},
        altitude_m=18202.702748137206,
        air={"module_temperature_c": -56.5},
        clearness=0.8388611635211468,
        uncertainty_margins={"solar_model_sigmas": 2.0},
    )
    largest = size_aircraft(NARROW, place, Objective.max_payload_mass, required_excess_time_h=0.0)
    # Optima are known to half a per cent.
    loaded = place.model_copy(
        update={"payload": type(place.payload)(mass_kg=share * largest.objective_value)}
    )
    found = size_aircraft(NARROW, loaded, Objective.min_wingspan, required_excess_time_h=0.0)
    assert found.status is status


@pytest.mark.parametrize(
    ("latitude_deg", "day", "date", "objective", "required_h"),
    [
        (46.0, 342, "12-08", Objective.min_wingspan, 2.0),
        (50.0, 322, "11-18", Objective.min_mass, 0.0),
        (48.0, 327, "11-23", Objective.max_payload_mass, 1.0),
    ],
)
def test_no_design_in_the_dark_season_is_infeasible_for_command_and_map(
    latitude_deg, day, date, objective, required_h
):
    plane = builders.DESIGN
    place = builders.shipped_mission(latitude_deg=latitude_deg, dates={"on": date})
    found = size_aircraft(plane, place, objective, required_excess_time_h=required_h)
    assert found.status is SizingStatus.infeasible
    assert {"battery_capacity", "energy_balance"} & {v.requirement for v in found.violations}
    scenarios = Scenarios(np.array([latitude_deg]), np.array([day]))
    cells = size_cells(plane, place, scenarios, objective, required_excess_time_h=required_h)
    assert cells.status.tolist() == [SizingStatus.infeasible]
