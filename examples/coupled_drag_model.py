"""
A drag model of one's own
=========================

The lightest aircraft for a summer, with the drag of a fuselage that the package does not know.

OpenMDAO couples the energy balance with the drag model, both ways: drag decides mass and load, and
the airspeed decides the drag. Needs the extra ``openmdao``.

Run with: ``python examples/coupled_drag_model.py``
"""

import openmdao.api as om

import missions
import sizing
import studies

PARASITIC = "airframe.aerodynamics.parasitic_drag_coefficient"


def coupled(*, with_fuselage: bool) -> om.Problem:
    """Least mass with 3 h of excess time, by the aircraft's own drag or that of a fuselage."""
    energy = studies.to_openmdao(
        sizing.load_aircraft("atlantiksolar-design"),
        missions.load_mission("central-europe-summer"),
        keys=[PARASITIC],
        required_excess_time_h=3.0,
    )
    problem = om.Problem(reports=False)
    model = problem.model
    aircraft = model.add_subsystem("aircraft", om.Group(), promotes=["*"])
    aircraft.add_subsystem("energy", energy, promotes=["*"])
    if with_fuselage:
        # A tail of 0.006, and turbulent skin friction of 0.5 m2 of pod, 1.8 m long, on the area of
        # the wing.
        fuselage = om.ExecComp(
            "drag = 0.006"
            " + 0.455 / log10(airspeed * 1.8 / 1.5e-5)**2.58 * 1.2 * 0.5 * ratio / span**2",
            airspeed={"val": 8.5, "units": "m/s"},
            span={"val": 5.65, "units": "m"},
            ratio=18.5,
            drag=0.008,
        )
        names = {
            "airspeed": "airspeed_m_per_s",
            "span": "wingspan_m",
            "ratio": "aspect_ratio",
            "drag": PARASITIC.replace(".", ":"),
        }
        aircraft.add_subsystem("fuselage", fuselage, promotes=list(names.items()))
        aircraft.nonlinear_solver = om.NonlinearBlockGS(iprint=-1, rtol=1e-10)
        aircraft.linear_solver = om.DirectSolver()
    # SLSQP takes whole steps at first: variables and mass are scaled to about one.
    for name, (lower, upper), usual in (
        ("wingspan_m", (2.0, 12.0), 5.0),
        ("battery_mass_kg", (0.2, 25.0), 3.0),
        ("module_area_m2", (0.1, 8.0), 1.0),
    ):
        model.add_design_var(name, lower=lower, upper=upper, ref=usual)
    model.add_objective("total_mass_kg", ref=7.0)
    # Excess time of 3 h: it fits into the battery, and the day returns it, with a thousandth to
    # spare.
    model.add_constraint("battery_capacity", lower=0.0)
    model.add_constraint("energy_balance", lower=1e-3)
    model.add_constraint("module_coverage", lower=0.0)
    problem.driver = om.ScipyOptimizeDriver(optimizer="SLSQP", tol=1e-9, disp=False)
    problem.setup()
    problem.run_driver()
    return problem


def main() -> None:
    """Print both designs."""
    for with_fuselage in (False, True):
        found = coupled(with_fuselage=with_fuselage)
        print("drag of a fuselage" if with_fuselage else "the aircraft's own drag")
        print(f"  parasitic drag {found[PARASITIC.replace('.', ':')][0]:.4f}")
        print(f"  span {found['wingspan_m'][0]:.2f} m, mass {found['total_mass_kg'][0]:.2f} kg")
        print(f"  worst excess time {found['excess_time_h'].min():.2f} h")


if __name__ == "__main__":
    main()
