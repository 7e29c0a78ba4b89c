"""
The energy balance in OpenMDAO
==============================

The battery for three hours of excess time through a summer, found by a solver of OpenMDAO.

The component flies a design through its days; a key that your own model computes is an input.
Needs ``pip install openmdao``.
"""

import openmdao.api as om

import missions
import sizing

KEYS = {"airframe.wingspan_m": "m", "battery.mass_kg": "kg", "modules.area_m2": "m**2"}
REQUIRED_H = 3.0


class EnergyBalance(om.ExplicitComponent):
    """Total mass and least excess time of a design; a key's underscores stand for its dots."""

    def setup(self):
        """Declare the inputs, with the values of the aircraft's file, and the results."""
        aircraft = sizing.load_aircraft("atlantiksolar-design").model_dump()
        for key in KEYS:
            part, name = key.split(".")
            self.add_input(f"{part}_{name}", aircraft[part][name], units=KEYS[key])
        self.add_output("total_mass_kg", units="kg")
        self.add_output("excess_time_h", units="h")
        # The simulator's own rounding lies far below a thousandth.
        self.declare_partials("*", "*", method="fd", step=1e-3, step_calc="rel_avg")

    def compute(self, inputs, outputs):
        """Fly the design."""
        changes = {key: float(inputs[key.replace(".", "_")][0]) for key in KEYS}
        aircraft = sizing.load_aircraft("atlantiksolar-design", changes)
        analysis = sizing.analyse(aircraft, missions.load_mission("central-europe-summer"))
        outputs["total_mass_kg"] = analysis.performance.design.total_mass_kg
        outputs["excess_time_h"] = analysis.excess_time_h


def main() -> None:
    """Print the battery and what the aircraft weighs with it."""
    problem = om.Problem(reports=False)
    model = problem.model
    model.add_subsystem("energy", EnergyBalance(), promotes=["*"])
    balance = om.BalanceComp(
        "battery_mass_kg", val=2.9, units="kg", eq_units="h", rhs_val=REQUIRED_H
    )
    model.add_subsystem(
        "balance", balance, promotes=[("lhs:battery_mass_kg", "excess_time_h"), "*"]
    )
    model.nonlinear_solver = om.NewtonSolver(solve_subsystems=False, iprint=-1, rtol=1e-6)
    model.linear_solver = om.DirectSolver()
    problem.setup()
    problem.run_model()
    battery_kg, excess_h = problem["battery_mass_kg"][0], problem["excess_time_h"][0]
    print(f"battery {battery_kg:.3f} kg, excess time {excess_h:.2f} h")


if __name__ == "__main__":
    main()
