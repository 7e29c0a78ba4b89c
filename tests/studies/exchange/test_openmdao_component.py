"""The energy balance as a component of OpenMDAO: its partials, and an optimum beside ``size``."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import AS2, DESIGN, mission, shipped_mission

from missions.mission import Mission
from sizing.mass_budget import design_of
from sizing.results.analysis import analyse
from sizing.results.sizing import size
from studies.exchange.openmdao_component import to_openmdao

pytestmark = pytest.mark.extra
om: Any = pytest.importorskip("openmdao.api")

DRAG = "airframe.aerodynamics.parasitic_drag_coefficient"
SUMMER = shipped_mission("central-europe-summer")
PLACES = mission(latitude_deg={"from_deg": 30.0, "to_deg": 50.0, "count": 2}, dates={"on": "03-21"})


def problem_of(place: Mission, **options: Any) -> Any:
    """Problem with nothing but the component, set up."""
    problem = om.Problem(reports=False)
    problem.model.add_subsystem("energy", to_openmdao(DESIGN, place, **options), promotes=["*"])
    return problem


def test_outputs_are_those_of_an_analysis() -> None:
    problem = problem_of(PLACES, correction="report")
    problem.setup()
    problem.run_model()
    frame = analyse(DESIGN, PLACES, correction="report").to_frame()
    # Within what the two time axes cost.
    for name, within in (
        ("excess_time_h", 0.01),
        ("charge_margin_h", 0.03),
        ("minimum_state_of_charge", 5e-4),
    ):
        np.testing.assert_allclose(problem[name], frame[name], atol=within)
    mass_kg = float(design_of(DESIGN, PLACES).total_mass_kg)
    assert problem.get_val("total_mass_kg", units="g")[0] == pytest.approx(1e3 * mass_kg)
    assert problem.get_val("module_area_m2", units="cm**2")[0] == pytest.approx(13500.0)
    assert problem.get_val("excess_time_h", units="min") == pytest.approx(
        60.0 * problem["excess_time_h"]
    )


@pytest.mark.filterwarnings(r"ignore:\s*Component .* has zero derivatives")
@pytest.mark.parametrize("area", [0.5, 1.35], ids=["limited", "perpetual"])
def test_partials_are_those_of_differences(area: float) -> None:
    problem = problem_of(
        PLACES, keys=[DRAG, "battery.specific_energy_wh_per_kg"], required_excess_time_h=3.0
    )
    problem.setup()
    problem.set_val("module_area_m2", area)
    problem.set_val("payload_mass_kg", 0.3)  # no step is relative to zero
    problem.set_val("payload_power_w", 2.0)
    problem.run_model()
    assert (problem["excess_time_h"] < 0.0).all() == (area < 1.0)
    checked = problem.check_partials(
        out_stream=None, method="fd", form="central", step=1e-6, step_calc="rel_avg"
    )
    for pair, one in checked["energy"].items():
        exact, differences = one["J_fwd"], one["J_fd"]
        # Central differences: what closing the mass and the day leaves, 1e-13, over the step.
        assert exact == pytest.approx(differences, rel=1e-5, abs=1e-5), pair


def test_the_lightest_design_is_that_of_size() -> None:
    problem = problem_of(SUMMER, required_excess_time_h=3.0)
    model = problem.model
    space = DESIGN.design_space
    for name, usual in (("wingspan_m", 5.0), ("battery_mass_kg", 3.0), ("module_area_m2", 1.0)):
        ends = getattr(space, name)
        model.add_design_var(name, lower=ends.minimum, upper=ends.maximum, ref=usual)
    model.add_objective("total_mass_kg", ref=7.0)
    model.add_constraint("battery_capacity", lower=0.0)
    model.add_constraint("energy_balance", lower=1e-3)
    model.add_constraint("module_coverage", lower=0.0)
    problem.driver = om.ScipyOptimizeDriver(optimizer="SLSQP", tol=1e-9, disp=False)
    problem.setup()
    assert problem.run_driver().exit_status != "FAIL"
    assert problem["excess_time_h"].min() == pytest.approx(3.0, abs=0.01)
    sized = size(DESIGN, SUMMER, "min_mass", required_excess_time_h=3.0)
    assert sized.design is not None
    assert problem["total_mass_kg"][0] == pytest.approx(sized.design.total_mass_kg, rel=0.003)
    variables = sized.design.variables
    assert problem["wingspan_m"][0] == pytest.approx(variables.wingspan_m, rel=0.003)
    # And the simulator flies it.
    flown = DESIGN.model_copy(
        update={
            "airframe": DESIGN.airframe.model_copy(
                update={"wingspan_m": float(problem["wingspan_m"][0])}
            ),
            "battery": DESIGN.battery.model_copy(
                update={"mass_kg": float(problem["battery_mass_kg"][0])}
            ),
            "modules": DESIGN.modules.model_copy(
                update={"area_m2": float(problem["module_area_m2"][0])}
            ),
        }
    )
    assert analyse(flown, SUMMER).excess_time_h == pytest.approx(3.0, abs=0.01)


def test_what_no_design_can_be_is_an_analysis_error() -> None:
    problem = problem_of(PLACES)
    problem.setup()
    problem.set_val("battery_mass_kg", 1e5)
    with pytest.raises(om.AnalysisError, match="cannot carry its own mass"):
        problem.run_model()


def test_what_is_no_aircraft_or_no_technology_is_refused() -> None:
    with pytest.raises(TypeError, match="expected Aircraft"):
        to_openmdao("atlantiksolar-design", PLACES)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="is a measured aircraft"):
        to_openmdao(AS2, PLACES)
    with pytest.raises(ValueError, match=r"power\.nothing cannot be an input"):
        to_openmdao(DESIGN, PLACES, keys=["power.nothing"])
